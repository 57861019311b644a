pathfit_test(optim/solver/trust_region_solver_test LABEL unit LINK pathfit_optim pathfit_test_support)
pathfit_test(optim/solver/step_bounds_test LABEL unit LINK pathfit_optim pathfit_test_support)
pathfit_test(optim/solver/sparse_errors_test LABEL unit LINK pathfit_optim pathfit_test_support)
