pathfit_test(renderer/path/path_tracer_test LABEL statistical LINK pathfit_test_support)
pathfit_test(renderer/path/mirror_normal_test LABEL unit LINK pathfit_test_support)
