pathfit_test(renderer/image/color_test LABEL unit LINK pathfit_renderer)
pathfit_test(renderer/image/image_test LABEL unit LINK pathfit_renderer)
pathfit_test(renderer/image/similarity_test LABEL unit LINK pathfit_renderer)
