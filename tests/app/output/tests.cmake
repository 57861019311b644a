foreach(name sha256 run_directory metrics_csv fit_history run_record svg_plot progress report_images
        report_html export_result fit_recorder signed_image)
  pathfit_test(app/output/${name}_test LABEL unit LINK "pathfit_app;nlohmann_json::nlohmann_json")
endforeach()
