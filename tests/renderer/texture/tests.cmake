pathfit_test(renderer/texture/texture_test LABEL unit LINK pathfit_renderer)
