pathfit_test(optim/problem/camera_guard_test LABEL unit LINK pathfit_optim pathfit_test_support)
pathfit_test(optim/problem/image_problem_test LABEL unit LINK pathfit_optim pathfit_test_support)
pathfit_test(optim/problem/residual_groups_test LABEL unit LINK pathfit_optim pathfit_test_support)
pathfit_test(optim/problem/vertex_guard_test LABEL unit LINK pathfit_optim pathfit_test_support)
