# What programs outside may include, as "pathfit/renderer/..." and "pathfit/optim/...". Closed under inclusion: a public
# header includes only public headers and the standard library (tests/architecture/public_headers_test.py).
set(PATHFIT_PUBLIC_HEADERS
  # Scenes: values that are copied and compared.
  renderer/core/shared_vector.h renderer/math/vector.h renderer/math/rgb.h renderer/math/transform.h renderer/math/frame.h renderer/math/warp.h
  renderer/geometry/mesh.h renderer/geometry/ray.h renderer/texture/texture.h renderer/bsdf/bsdf.h
  renderer/emitter/emitter.h renderer/sensor/lens_distortion.h renderer/sensor/vignetting.h renderer/sensor/camera.h renderer/scene/scene.h
  # Meshes and images: made, mended, read and written.
  renderer/geometry/mesh_primitives.h renderer/geometry/mesh_normals.h renderer/geometry/mesh_repair.h
  renderer/image/image.h renderer/image/color.h
  renderer/io/mesh_file.h renderer/io/ply_file.h renderer/io/gltf_reader.h renderer/io/gltf_writer.h
  renderer/io/image_file.h renderer/io/image_filter.h renderer/io/exr_file.h renderer/io/texture_file.h renderer/io/raw_file.h
  # Images and their derivatives.
  renderer/core/error.h renderer/core/parallel.h renderer/render_options.h renderer/render_stats.h
  renderer/scene/parameter_kinds.h renderer/scene/parameter_layout.h renderer/derivative/derivative_sink.h renderer/derivative/film_sink.h
  renderer/renderer.h
  # Photos in, moved parameters out.
  optim/observation/observation.h optim/observation/load_observations.h optim/observation/packed_image.h
  optim/parameter/unknown_spec.h optim/parameter/parameter_set.h
  optim/problem/loss_spec.h optim/round/fit_spec.h optim/round/fit_report.h optim/problem/quadratic_model.h
  optim/problem/row_history.h optim/problem/round_sums.h optim/checkpoint/fit_state.h optim/round/fit.h
  optim/diagnostics/gradient_check.h)
