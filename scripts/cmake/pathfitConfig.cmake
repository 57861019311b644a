# find_package(pathfit): targets pathfit::renderer and pathfit::optim. The libraries are static, so what they use is found
# again here.
include(CMakeFindDependencyMacro)
find_dependency(embree 3 CONFIG)
find_dependency(TBB)
find_dependency(OpenEXR 3 CONFIG)
find_dependency(TinyGLTF CONFIG)
find_dependency(nlohmann_json 3)
find_dependency(Ceres 2.1)
find_dependency(OpenMesh)
find_dependency(pugixml)
find_dependency(yaml-cpp)
include(${CMAKE_CURRENT_LIST_DIR}/pathfitTargets.cmake)
