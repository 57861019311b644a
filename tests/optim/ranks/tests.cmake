pathfit_test(optim/ranks/division_test LABEL unit LINK pathfit_optim pathfit_test_support)

# The file that knows MPI, built without it.
add_executable(optim_ranks_without_mpi
  ${CMAKE_CURRENT_LIST_DIR}/ranks_without_mpi_test.cpp ${PROJECT_SOURCE_DIR}/optim/ranks/ranks.cpp
  ${PROJECT_SOURCE_DIR}/optim/ranks/division.cpp)
target_compile_definitions(optim_ranks_without_mpi PRIVATE PATHFIT_MPI=0)
target_link_libraries(optim_ranks_without_mpi PRIVATE pathfit_renderer GTest::gtest_main)
add_unit_tests(optim/ranks/without_mpi optim_ranks_without_mpi)

if(PATHFIT_MPI AND NOT PATHFIT_QUICK_TESTS)
  add_test(NAME e2e/ranks
    COMMAND Python3::Interpreter ${PROJECT_SOURCE_DIR}/tests/e2e/ranks_test.py $<TARGET_FILE:pathfit> ${PROJECT_SOURCE_DIR}
      ${MPIEXEC_EXECUTABLE})
  set_tests_properties(e2e/ranks PROPERTIES LABELS mpi TIMEOUT 600 COST 50)
endif()
