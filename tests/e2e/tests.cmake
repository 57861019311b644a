if(NOT PATHFIT_QUICK_TESTS)
  add_test(NAME e2e/program
    COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/program_test.py $<TARGET_FILE:pathfit> ${PROJECT_SOURCE_DIR})
  set_tests_properties(e2e/program PROPERTIES LABELS e2e TIMEOUT 1200)
endif()
