pathfit_test(renderer/scene/light_set_test LABEL unit LINK pathfit_test_support)
pathfit_test(renderer/scene/parameter_layout_test LABEL unit LINK pathfit_test_support)
pathfit_test(renderer/scene/scene_test LABEL unit LINK pathfit_test_support)
pathfit_test(renderer/scene/view_bounds_test LABEL unit LINK pathfit_test_support)
