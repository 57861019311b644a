# What several tests share; linked, not run.
add_library(pathfit_test_support STATIC ${CMAKE_CURRENT_LIST_DIR}/test_scenes.cpp)
target_link_libraries(pathfit_test_support PUBLIC pathfit_renderer)
