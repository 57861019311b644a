find_package(Ceres REQUIRED)
pathfit_test(renderer/bsdf/bsdf_test LABEL unit LINK pathfit_renderer)
pathfit_test(renderer/bsdf/bsdf_sampling_test LABEL statistical LINK pathfit_renderer)
pathfit_test(renderer/bsdf/microfacet_kernel_test LABEL unit LINK pathfit_renderer Ceres::ceres)
