pathfit_test(app/experiment/closed_form_scenes_test LABEL statistical LINK pathfit_app)
