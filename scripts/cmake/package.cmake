# Debian packages of what cmake --install puts in place: cpack -G DEB --config build/release/CPackConfig.cmake -B build/packages
# The program's own dependencies are found by dpkg-shlibdeps (package dpkg-dev).
set(CPACK_PACKAGE_NAME pathfit)
set(CPACK_PACKAGE_CONTACT "The pathfit maintainers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Fits meshes, materials, lights and cameras to photographs")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
  "A path-space differentiable renderer gives residuals and sparse Jacobians to a second-order solver, which moves
 vertices, materials, lights and cameras until rendered images agree with photographs.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program dev)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME pathfit)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
if(PATHFIT_MPI)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "openmpi-bin")  # mpirun
endif()
set(CPACK_COMPONENT_DEV_DESCRIPTION "Libraries and headers of pathfit, for find_package(pathfit)")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libpathfit-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
# What pathfitConfig.cmake finds, and what the static libraries are linked with.
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
  "libembree-dev, libtbb-dev, libopenexr-dev, libtinygltf-dev, libdraco-dev, libmeshoptimizer-dev, nlohmann-json3-dev, libceres-dev, libopenmesh-dev, libopenvdb-dev, libopenblas-dev, libopencv-core-dev, libopencv-imgproc-dev, libopencv-imgcodecs-dev, libexif-dev, liblcms2-dev, zlib1g-dev, libpugixml-dev, libyaml-cpp-dev")
if(PATHFIT_RAW)
  string(APPEND CPACK_DEBIAN_DEV_PACKAGE_DEPENDS ", libraw-dev")
endif()
if(PATHFIT_MPI)
  string(APPEND CPACK_DEBIAN_DEV_PACKAGE_DEPENDS ", libopenmpi-dev")
endif()
if(PATHFIT_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION "The Python module of pathfit")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-pathfit)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}), python3-numpy, python3-scipy")
endif()
include(CPack)
