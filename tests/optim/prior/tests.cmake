pathfit_test(optim/prior/prior_terms_test LABEL unit LINK pathfit_optim pathfit_test_support)
