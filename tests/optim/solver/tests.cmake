pathfit_test(optim/solver/linear_solver_policy_test LABEL unit LINK pathfit_optim)
pathfit_test(optim/solver/trust_region_solver_test LABEL unit LINK pathfit_optim pathfit_test_support)
