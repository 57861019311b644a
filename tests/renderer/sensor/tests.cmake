find_package(Ceres REQUIRED)
pathfit_test(renderer/sensor/perspective_camera_test LABEL unit LINK pathfit_renderer Ceres::ceres)
