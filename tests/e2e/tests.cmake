if(NOT PATHFIT_QUICK_TESTS)
  if(PATHFIT_PYTHON)
    set(with_python_tutorial $<TARGET_FILE:Python::Interpreter> $<TARGET_FILE_DIR:pathfit_python>)
  endif()
  foreach(test program render truth command page sfm tutorial gltf viewer)
    add_test(NAME e2e/${test}
      COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/${test}_test.py $<TARGET_FILE:pathfit> ${PROJECT_SOURCE_DIR}
        ${with_python_${test}})
    # The longest begin first (COST), so that none is left to run alone.
    set_tests_properties(e2e/${test} PROPERTIES LABELS e2e TIMEOUT 1200 COST 50)
  endforeach()
  set_tests_properties(e2e/program PROPERTIES COST 300)
  set_tests_properties(e2e/page PROPERTIES COST 100)
  set_tests_properties(e2e/gltf PROPERTIES SKIP_RETURN_CODE 77)
  add_test(NAME e2e/install
    COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/install_test.py
      ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR} ${CMAKE_CXX_COMPILER})
  add_test(NAME e2e/package
    COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/package_test.py ${PROJECT_BINARY_DIR})
  if(PATHFIT_PYTHON)
    add_test(NAME e2e/python
      COMMAND Python::Interpreter ${CMAKE_CURRENT_LIST_DIR}/python_test.py
        $<TARGET_FILE:pathfit> ${PROJECT_SOURCE_DIR} $<TARGET_FILE_DIR:pathfit_python>)
    set_tests_properties(e2e/python PROPERTIES LABELS e2e TIMEOUT 600 COST 50)
  endif()
  set_tests_properties(e2e/install e2e/package PROPERTIES LABELS e2e TIMEOUT 600 COST 50)
endif()
