foreach(name sha256 run_directory fit_history run_record progress report_images report export_result fit_recorder
        signed_image fields export_formats comparison viewed_model remaining_time)
  pathfit_test(app/output/${name}_test LABEL unit LINK "pathfit_app;nlohmann_json::nlohmann_json;pathfit_test_support")
endforeach()

# The script of the report's page, where there is something to run it with.
find_program(NODE node)
if(NODE)
  add_test(NAME app/output/report_page
    COMMAND ${NODE} ${CMAKE_CURRENT_LIST_DIR}/report_page_test.js ${PROJECT_SOURCE_DIR}/app/output/report/viewer.js
      ${PROJECT_SOURCE_DIR}/app/output/report/report.js)
  set_tests_properties(app/output/report_page PROPERTIES LABELS unit)
endif()
pathfit_test(app/output/synthetic_photos_test LABEL unit LINK pathfit_app pathfit_test_support)
pathfit_test(app/output/evaluation_test LABEL unit LINK pathfit_app pathfit_test_support)
pathfit_test(app/output/config_json_test LABEL unit LINK pathfit_app nlohmann_json::nlohmann_json)
pathfit_test(app/output/check_page_test LABEL unit LINK pathfit_app nlohmann_json::nlohmann_json pathfit_test_support)
