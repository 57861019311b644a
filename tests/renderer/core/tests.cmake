pathfit_test(renderer/core/shared_vector_test LABEL unit LINK pathfit_renderer)
pathfit_test(renderer/core/check_test LABEL unit LINK pathfit_renderer)
pathfit_test(renderer/core/process_memory_test LABEL unit LINK pathfit_renderer)
pathfit_test(renderer/core/parallel_test LABEL parallel LINK pathfit_renderer)
