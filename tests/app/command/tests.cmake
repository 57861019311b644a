pathfit_test(app/command/command_line_test LABEL unit LINK pathfit_app)
pathfit_test(app/command/run_scene_test LABEL unit LINK pathfit_app)
pathfit_test(app/command/shell_completion_test LABEL unit LINK pathfit_app nlohmann_json::nlohmann_json)
