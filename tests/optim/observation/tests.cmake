foreach(test camera_formats camera_import exif_exposure load_observations located_point object_masks view_level visual_hull voxel_surface)
  pathfit_test(optim/observation/${test}_test LABEL unit LINK pathfit_optim)
endforeach()
