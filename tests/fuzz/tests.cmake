# Damaged files for every reader: in a few seconds here, by hand for as long as one likes (README.md).
add_executable(fuzz
  ${CMAKE_CURRENT_LIST_DIR}/fuzz.cpp ${CMAKE_CURRENT_LIST_DIR}/fuzz_targets.cpp ${CMAKE_CURRENT_LIST_DIR}/mutator.cpp)
target_link_libraries(fuzz PRIVATE pathfit_app pathfit_test_support nlohmann_json::nlohmann_json ${LCMS_LIBRARY} ZLIB::ZLIB)
compile_cold(fuzz)
add_test(NAME fuzz/readers COMMAND fuzz --inputs 400)
set_tests_properties(fuzz/readers PROPERTIES LABELS unit TIMEOUT 600)
