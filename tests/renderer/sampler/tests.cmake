pathfit_test(renderer/sampler/counter_rng_test LABEL unit LINK pathfit_renderer)
pathfit_test(renderer/sampler/lattice_sampler_test LABEL unit LINK pathfit_renderer)
