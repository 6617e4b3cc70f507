#include "sim/ground/export/gltf_writer.hpp"

#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <ostream>
#include <stdexcept>
#include <string>

#include "sim/host/picture.hpp"

namespace ilp::exports {
namespace {

using Float3 = std::array<float, 3>;

// The anchor's height stays out, so that single precision has its digits for the relief.
Float3 gltf_point(const map::SurfaceVertex& v, const Georeference& place) {
  const Vec3 p = place.map_from_world({v.x, v.y, v.z});
  return {static_cast<float>(p.x()), static_cast<float>(p.z() - place.height), static_cast<float>(-p.y())};
}

std::vector<Float3> positions(const map::SurfaceMesh& mesh, const Georeference& place) {
  std::vector<Float3> points;
  points.reserve(mesh.vertices.size());
  for (const map::SurfaceVertex& v : mesh.vertices) points.push_back(gltf_point(v, place));
  return points;
}

// Mean of the faces at a vertex, by their areas; upwards where there is none.
std::vector<Float3> normals(const map::SurfaceMesh& mesh, const std::vector<Float3>& points) {
  std::vector<Vec3> sums(points.size(), Vec3::Zero());
  const auto point = [&](std::uint32_t i) { return Vec3(points[i][0], points[i][1], points[i][2]); };
  for (const auto& face : mesh.faces) {
    const Vec3 a = point(face[0]);
    const Vec3 area = (point(face[1]) - a).cross(point(face[2]) - a);
    for (const std::uint32_t i : face) sums[i] += area;
  }
  std::vector<Float3> out;
  out.reserve(sums.size());
  for (const Vec3& sum : sums) {
    const double length = sum.norm();
    const Vec3 n = length > 0 ? Vec3(sum / length) : Vec3(0, 1, 0);
    out.push_back({static_cast<float>(n.x()), static_cast<float>(n.y()), static_cast<float>(n.z())});
  }
  return out;
}

std::vector<std::array<float, 2>> texture_places(const map::SurfaceMesh& mesh, const map::MapGeometry& map) {
  std::vector<std::array<float, 2>> places;
  places.reserve(mesh.vertices.size());
  for (const map::SurfaceVertex& v : mesh.vertices) {
    places.push_back({static_cast<float>(((v.x - map.x0) / map.cell + 0.5) / map.columns),
                      static_cast<float>(((map.y0 - v.y) / map.cell + 0.5) / map.rows)});
  }
  return places;
}

// Fills the one buffer of a file, part by part.
class BufferFiller {
 public:
  BufferFiller(tinygltf::Model& model, std::size_t expected_bytes) : model_(model) {
    model_.buffers.resize(1);
    model_.buffers[0].data.reserve(expected_bytes);
  }

  int add_view(const void* from, std::size_t bytes, int target) {
    std::vector<unsigned char>& data = model_.buffers[0].data;
    if (bytes > std::numeric_limits<std::uint32_t>::max() - data.size() - 4096) {
      throw std::runtime_error("the surface is too large for one glTF file");
    }
    data.resize((data.size() + 3) / 4 * 4);
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = data.size();
    view.byteLength = bytes;
    view.target = target;
    const auto* begin = static_cast<const unsigned char*>(from);
    data.insert(data.end(), begin, begin + bytes);
    model_.bufferViews.push_back(view);
    return static_cast<int>(model_.bufferViews.size()) - 1;
  }

  tinygltf::Accessor& add_accessor(int view, int component, int type, std::size_t count) {
    tinygltf::Accessor accessor;
    accessor.bufferView = view;
    accessor.componentType = component;
    accessor.type = type;
    accessor.count = count;
    model_.accessors.push_back(accessor);
    return model_.accessors.back();
  }

  template <typename Element>
  int add_attribute(const std::vector<Element>& elements, int type) {
    const int view = add_view(elements.data(), elements.size() * sizeof(Element), TINYGLTF_TARGET_ARRAY_BUFFER);
    add_accessor(view, TINYGLTF_COMPONENT_TYPE_FLOAT, type, elements.size());
    return last_accessor();
  }

  [[nodiscard]] int last_accessor() const { return static_cast<int>(model_.accessors.size()) - 1; }

 private:
  tinygltf::Model& model_;
};

void add_bounds(tinygltf::Accessor& accessor, const std::vector<Float3>& points) {
  Float3 least = points.front(), most = points.front();
  for (const Float3& p : points) {
    for (std::size_t i = 0; i < 3; ++i) {
      least[i] = std::min(least[i], p[i]);
      most[i] = std::max(most[i], p[i]);
    }
  }
  accessor.minValues.assign(least.begin(), least.end());
  accessor.maxValues.assign(most.begin(), most.end());
}

int add_indices(const map::SurfaceMesh& mesh, BufferFiller& buffer) {
  const std::size_t count = 3 * mesh.faces.size();
  // The largest 16-bit index means a restart.
  if (mesh.vertices.size() > 65535) {
    const int view = buffer.add_view(mesh.faces.data(), count * 4, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    buffer.add_accessor(view, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR, count);
  } else {
    std::vector<std::uint16_t> indices;
    indices.reserve(count);
    for (const auto& face : mesh.faces) {
      for (const std::uint32_t i : face) indices.push_back(static_cast<std::uint16_t>(i));
    }
    const int view = buffer.add_view(indices.data(), count * 2, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    buffer.add_accessor(view, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_SCALAR, count);
  }
  return buffer.last_accessor();
}

tinygltf::Primitive primitive_of(const map::SurfaceMesh& mesh, const map::MapGeometry& map, const Georeference& place,
                                 tinygltf::Model& model, BufferFiller& buffer) {
  const std::vector<Float3> points = positions(mesh, place);
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.material = 0;
  primitive.attributes["POSITION"] = buffer.add_attribute(points, TINYGLTF_TYPE_VEC3);
  add_bounds(model.accessors.back(), points);
  primitive.attributes["NORMAL"] = buffer.add_attribute(normals(mesh, points), TINYGLTF_TYPE_VEC3);
  primitive.attributes["TEXCOORD_0"] = buffer.add_attribute(texture_places(mesh, map), TINYGLTF_TYPE_VEC2);
  primitive.indices = add_indices(mesh, buffer);
  return primitive;
}

void add_material(const host::Raster<std::uint8_t>& picture, tinygltf::Model& model, BufferFiller& buffer) {
  const std::vector<std::uint8_t> png = host::png_bytes(picture);
  tinygltf::Image image;
  image.mimeType = "image/png";
  image.bufferView = buffer.add_view(png.data(), png.size(), 0);
  model.images.push_back(image);
  tinygltf::Sampler sampler;
  sampler.magFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
  sampler.minFilter = TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR;
  sampler.wrapS = sampler.wrapT = TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
  model.samplers.push_back(sampler);
  tinygltf::Texture texture;
  texture.sampler = texture.source = 0;
  model.textures.push_back(texture);
  tinygltf::Material material;
  material.name = "orthoimage";
  material.doubleSided = true;
  material.pbrMetallicRoughness.baseColorTexture.index = 0;
  material.pbrMetallicRoughness.metallicFactor = 0;
  material.pbrMetallicRoughness.roughnessFactor = 1;
  model.materials.push_back(material);
}

void add_scene(tinygltf::Primitive primitive, const Georeference& place, tinygltf::Model& model) {
  tinygltf::Mesh surface;
  surface.name = "surface";
  surface.primitives.push_back(std::move(primitive));
  model.meshes.push_back(surface);
  tinygltf::Node node;
  node.mesh = 0;
  model.nodes.push_back(node);
  tinygltf::Scene scene;
  scene.nodes = {0};
  model.scenes.push_back(scene);
  model.defaultScene = 0;
  model.asset.version = "2.0";
  model.asset.generator = "ilp-ground";
  model.asset.extras = tinygltf::Value(tinygltf::Value::Object{{"unit", tinygltf::Value(place.unit)},
                                                               {"place", tinygltf::Value(place.sentence)},
                                                               {"height_of_zero", tinygltf::Value(place.height)}});
}

}  // namespace

void write_gltf(const map::SurfaceMesh& mesh, const map::MapGeometry& map, const host::Raster<std::uint8_t>& texture,
                const Georeference& place, std::ostream& out) {
  if (mesh.faces.empty()) throw std::runtime_error("a surface without a face");
  tinygltf::Model model;
  // Positions, normals, places in the texture; three indices; a picture is rarely larger than its samples.
  BufferFiller buffer(model, 32 * mesh.vertices.size() + 12 * mesh.faces.size() + texture.samples.size() + 4096);
  tinygltf::Primitive primitive = primitive_of(mesh, map, place, model, buffer);
  add_material(texture, model, buffer);
  add_scene(std::move(primitive), place, model);
  if (!tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, out, false, true)) {
    throw std::runtime_error("the glTF file cannot be made");
  }
}

}  // namespace ilp::exports
