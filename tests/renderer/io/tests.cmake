find_package(OpenEXR 3 REQUIRED CONFIG)
find_package(ZLIB REQUIRED)
find_package(meshoptimizer REQUIRED CONFIG)
find_package(nlohmann_json 3 REQUIRED)
pathfit_test(renderer/io/atomic_file_test LABEL unit LINK pathfit_renderer)
pathfit_test(renderer/io/text_scanner_test LABEL unit LINK pathfit_renderer)
pathfit_test(renderer/io/mesh_assembly_test LABEL unit LINK pathfit_renderer)
pathfit_test(renderer/io/obj_reader_test LABEL unit LINK pathfit_renderer)
pathfit_test(renderer/io/ply_file_test LABEL unit LINK pathfit_renderer)
pathfit_test(renderer/io/stl_reader_test LABEL unit LINK pathfit_renderer)
pathfit_test(renderer/io/gltf_writer_test LABEL unit
  LINK pathfit_renderer nlohmann_json::nlohmann_json)
pathfit_test(renderer/io/gltf_reader_test LABEL unit
  LINK pathfit_renderer nlohmann_json::nlohmann_json)
pathfit_test(renderer/io/gltf_compression_test LABEL unit
  LINK pathfit_renderer pathfit_test_support meshoptimizer::meshoptimizer)
pathfit_test(renderer/io/exr_file_test LABEL unit LINK pathfit_renderer OpenEXR::OpenEXR)
pathfit_test(renderer/io/image_file_test LABEL unit LINK pathfit_renderer pathfit_opencv)
pathfit_test(renderer/io/color_profile_test LABEL unit LINK pathfit_renderer ${LCMS_LIBRARY} ZLIB::ZLIB)
pathfit_test(renderer/io/color_segmentation_test LABEL unit LINK pathfit_renderer)
pathfit_test(renderer/io/image_filter_test LABEL unit LINK pathfit_renderer)
pathfit_test(renderer/io/texture_file_test LABEL unit LINK pathfit_renderer)
pathfit_test(renderer/io/raw_file_test LABEL unit LINK pathfit_renderer)

# The file that knows LibRaw, built without it.
add_executable(renderer_io_without_libraw
  ${CMAKE_CURRENT_LIST_DIR}/raw_file_without_libraw_test.cpp ${PROJECT_SOURCE_DIR}/renderer/io/raw_file.cpp)
target_compile_definitions(renderer_io_without_libraw PRIVATE PATHFIT_RAW=0)
target_link_libraries(renderer_io_without_libraw PRIVATE pathfit_renderer GTest::gtest_main)
add_unit_tests(renderer/io/without_libraw renderer_io_without_libraw)
