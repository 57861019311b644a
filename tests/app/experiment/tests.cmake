pathfit_test(app/experiment/closed_form_scenes_test LABEL statistical LINK pathfit_app)
pathfit_test(app/experiment/build_scene_test LABEL unit LINK pathfit_app)
pathfit_test(app/experiment/direction_test LABEL unit LINK pathfit_app)
pathfit_test(app/experiment/read_unknowns_test LABEL unit LINK pathfit_app)
