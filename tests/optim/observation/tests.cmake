foreach(test camera_formats camera_import cushion exif_exposure lamp_list load_observations located_point mirror_ball object_masks shading view_level visual_hull voxel_surface)
  pathfit_test(optim/observation/${test}_test LABEL unit LINK pathfit_optim)
endforeach()
