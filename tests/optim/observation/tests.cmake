foreach(test camera_import load_observations manifold_repair view_level visual_hull)
  pathfit_test(optim/observation/${test}_test LABEL unit LINK pathfit_optim)
endforeach()
