pathfit_test(optim/checkpoint/checkpoint_test LABEL unit LINK pathfit_optim pathfit_test_support)
