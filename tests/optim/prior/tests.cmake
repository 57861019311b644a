find_package(Ceres 2.1 REQUIRED)
pathfit_test(optim/prior/prior_terms_test LABEL unit LINK pathfit_optim pathfit_test_support Ceres::ceres)
