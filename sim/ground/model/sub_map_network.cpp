#include "sim/ground/model/sub_map_network.hpp"

#include <algorithm>
#include <cmath>

#include "sim/host/alignment.hpp"

namespace ilp::model {
namespace {

constexpr int most_steps = 30;
/// A step that takes less than this from the squares, in variances of a residual, is the last one: what it leaves is a
/// small part of it.
constexpr double negligible = 4;
/// Factors are used again while each step takes less than this share of what the one before took.
constexpr double least_fall_share = 0.05;
/// Where a camera stands farther from its place in a sub-map, as a share of the map's reach, the sub-map does not
/// determine it, and its equations are those of another place.
constexpr double most_bent = 0.05;

/// The cameras of all maps as unknowns.
class Network {
 public:
  Network(const std::vector<const SubMap*>& maps, const Model& model)
      : maps_(maps), camera_of_(model.views.size(), 0), system_(related(maps, model)) {}

  /// The equations where the model stands, and their factors.
  [[nodiscard]] bool factor(const Model& model) {
    system_.clear();
    choose_gauge(model);
    if (!sum(model, true)) return false;
    for (std::uint32_t c = 0; c < views_.size(); ++c) {
      for (int k = 0; k < 6; ++k) {
        if (held(c, k)) system_.hold(c, k);
      }
    }
    return system_.factor();
  }

  /// Only the right sides where the model stands: the factors stay.
  [[nodiscard]] bool look_again(const Model& model) { return sum(model, false); }

  /// By how much the squares fall.
  double step(Model& model) const {
    std::vector<Vec6> step = right_;
    system_.solve(step);
    double fall = 0;
    for (std::size_t c = 0; c < step.size(); ++c) {
      RigidTransform& pose = model.views[views_[c]].camera_from_model;
      const Vec3 centre = centre_of(pose) + step[c].tail<3>();
      pose.rotation = rotation_from_vector(step[c].head<3>()) * pose.rotation;
      pose.translation = -(pose.rotation * centre);
      fall += step[c].dot(right_[c]);
    }
    return fall;
  }

  /// Of a residual, where the cameras stood before the step.
  [[nodiscard]] double variance() const {
    double squares = twice_cost_, redundancy = 7 - 6.0 * static_cast<double>(views_.size());
    for (const SubMap* map : maps_) {
      squares += map->squares;
      redundancy += map->redundancy;
    }
    return redundancy > 0 ? squares / redundancy : 0;
  }

  void state_errors(Model& model) const {
    const std::vector<Mat6> inverse = system_.inverse_diagonal();
    CommonErrors common;
    for (const SubMap* map : maps_) common.add(map->common);
    const double factor = variance() * common.factor();
    for (std::size_t c = 0; c < views_.size(); ++c) {
      Mat6 covariance = factor * inverse[c];
      for (int k = 0; k < 6; ++k) {
        if (!held(c, k)) continue;
        covariance.row(k).setZero();
        covariance.col(k).setZero();
      }
      model.views[views_[c]].covariance = lower_triangle(covariance);
    }
  }

 private:
  RelatedCameras related(const std::vector<const SubMap*>& maps, const Model& model) {
    std::vector<std::uint8_t> seen(model.views.size(), 0);
    for (const SubMap* map : maps) {
      for (const SubMapCamera& camera : map->cameras) seen[camera.view] = 1;
    }
    for (std::uint32_t v = 0; v < seen.size(); ++v) {
      if (seen[v] == 0) continue;
      camera_of_[v] = static_cast<std::uint32_t>(views_.size());
      views_.push_back(v);
    }
    RelatedCameras related(views_.size());
    for (const SubMap* map : maps) {
      for (const CameraBlock& block : map->blocks)
        related[number(*map, block.row)].push_back(number(*map, block.column));
    }
    return related;
  }
  [[nodiscard]] std::uint32_t number(const SubMap& map, std::uint32_t place) const {
    return camera_of_[map.cameras[place].view];
  }

  [[nodiscard]] bool sum(const Model& model, bool with_blocks) {
    right_.assign(views_.size(), Vec6::Zero());
    twice_cost_ = 0;
    for (const SubMap* map : maps_) {
      if (!add(*map, model, with_blocks)) return false;
    }
    for (std::size_t c = 0; c < views_.size(); ++c) {
      for (int k = 0; k < 6; ++k) right_[c][k] = held(c, k) ? 0 : right_[c][k];
    }
    return true;
  }

  /// The map stands where its cameras are on average; what is left moves them in it.
  [[nodiscard]] bool add(const SubMap& map, const Model& model, bool with_blocks) {
    const auto model_from_map = model_from_sub_map(map, model);
    if (!model_from_map) return false;
    const Mat3 map_axes = model_from_map->rotation.transpose() / model_from_map->scale;
    std::vector<Vec6> moved(map.cameras.size()), down(map.cameras.size());
    for (std::size_t c = 0; c < map.cameras.size(); ++c) {
      const RigidTransform& in_map = map.cameras[c].camera_from_map;
      const RigidTransform& in_model = model.views[map.cameras[c].view].camera_from_model;
      const Mat3 from_map = in_model.rotation * model_from_map->rotation;
      moved[c].head<3>() = vector_from_rotation(from_map * in_map.rotation.transpose());
      moved[c].tail<3>() = map_axes * (centre_of(in_model) - model_from_map->translation) - centre_of(in_map);
      down[c] = map.cameras[c].right;
      twice_cost_ -= 2 * map.cameras[c].right.dot(moved[c]) / map.weight;
    }
    for (const CameraBlock& block : map.blocks) {
      const Vec6 by_column = block.block * moved[block.column];
      down[block.row] -= by_column;
      const bool diagonal = block.row == block.column;
      if (!diagonal) down[block.column] -= block.block.transpose() * moved[block.row];
      twice_cost_ += (diagonal ? 1 : 2) * moved[block.row].dot(by_column) / map.weight;
      if (!with_blocks) continue;
      Mat6 in_model = block.block / map.weight;
      in_model.rightCols<3>() = (in_model.rightCols<3>() * map_axes).eval();
      in_model.bottomRows<3>() = (map_axes.transpose() * in_model.bottomRows<3>()).eval();
      system_.add(number(map, block.row), number(map, block.column), in_model);
    }
    for (std::uint32_t c = 0; c < down.size(); ++c) {
      Vec6& right = right_[number(map, c)];
      right.head<3>() += down[c].head<3>() / map.weight;
      right.tail<3>() += map_axes.transpose() * down[c].tail<3>() / map.weight;
    }
    return true;
  }

  /// As gauge_of() an adjustment.
  void choose_gauge(const Model& model) {
    const Vec3 first = centre_of(model.views[views_.front()].camera_from_model);
    double longest = 0;
    for (std::size_t c = 0; c < views_.size(); ++c) {
      const Vec3 offset = centre_of(model.views[views_[c]].camera_from_model) - first;
      for (int k = 0; k < 3; ++k) {
        if (std::fabs(offset[k]) <= longest) continue;
        longest = std::fabs(offset[k]);
        anchor_ = c;
        component_ = k;
      }
    }
  }
  [[nodiscard]] bool held(std::size_t camera, int unknown) const {
    return camera == 0 || (camera == anchor_ && unknown == 3 + component_);
  }

  const std::vector<const SubMap*>& maps_;
  std::vector<std::uint32_t> views_;      ///< by camera
  std::vector<std::uint32_t> camera_of_;  ///< by view
  CameraSystem system_;
  std::vector<Vec6> right_;
  double twice_cost_ = 0;  ///< less the sub-maps' own squares
  std::size_t anchor_ = 0;
  int component_ = 0;
};

}  // namespace

std::optional<Similarity> model_from_sub_map(const SubMap& map, const Model& model) {
  std::vector<Vec3> in_map, in_model;
  std::vector<Mat3> map_attitudes, model_attitudes;
  for (const SubMapCamera& camera : map.cameras) {
    const ModelView& view = model.views[camera.view];
    if (!view.in) continue;
    in_map.push_back(centre_of(camera.camera_from_map));
    map_attitudes.push_back(camera.camera_from_map.rotation);
    in_model.push_back(centre_of(view.camera_from_model));
    model_attitudes.push_back(view.camera_from_model.rotation);
  }
  double reach = 0;
  for (const Vec3& c : in_model) reach = std::max(reach, (c - in_model.front()).norm());
  if (!(reach > 0)) return std::nullopt;
  const auto aligned = host::align_cameras(in_map, map_attitudes, in_model, model_attitudes, reach);
  if (!aligned || !(aligned->scale > 0)) return std::nullopt;
  return Similarity{aligned->rotation, aligned->translation, aligned->scale};
}

std::vector<const SubMap*> place_sub_maps(const std::vector<SubMap>& maps, std::size_t first,
                                          std::vector<std::uint8_t>& taken, Model& model) {
  std::vector<const SubMap*> placed;
  std::vector<std::vector<std::size_t>> maps_of(model.views.size());
  for (std::size_t m = 0; m < maps.size(); ++m) {
    for (const SubMapCamera& camera : maps[m].cameras) maps_of[camera.view].push_back(m);
  }
  std::vector<std::size_t> common(maps.size(), 0), failed_at(maps.size(), 0);
  const auto place = [&](std::size_t m, const Similarity& model_from_map) {
    taken[m] = 1;
    placed.push_back(&maps[m]);
    for (const SubMapCamera& camera : maps[m].cameras) {
      if (model.views[camera.view].in) continue;
      model.views[camera.view] = {true, moved(model_from_map, camera.camera_from_map)};
      for (const std::size_t other : maps_of[camera.view]) ++common[other];
    }
  };
  place(first, Similarity{});
  while (true) {
    std::size_t best = maps.size(), most = 1;
    for (std::size_t m = 0; m < maps.size(); ++m) {
      if (taken[m] != 0 || common[m] <= most || failed_at[m] == common[m]) continue;
      most = common[m];
      best = m;
    }
    if (best == maps.size()) return placed;
    failed_at[best] = common[best];
    if (const auto similarity = model_from_sub_map(maps[best], model)) place(best, *similarity);
  }
}

namespace {

bool bent(const SubMap& map, const Model& model) {
  const auto model_from_map = model_from_sub_map(map, model);
  if (!model_from_map) return true;
  const Vec3 first = centre_of(map.cameras.front().camera_from_map);
  double reach = 0, farthest = 0;
  for (const SubMapCamera& camera : map.cameras) {
    const Vec3 in_map = centre_of(camera.camera_from_map);
    const Vec3 offset = centre_of(model.views[camera.view].camera_from_model) - *model_from_map * in_map;
    reach = std::max(reach, (in_map - first).norm());
    farthest = std::max(farthest, offset.norm() / model_from_map->scale);
  }
  return farthest > most_bent * reach;
}

}  // namespace

bool adjust_network(const std::vector<const SubMap*>& maps, const std::function<void(Model&)>& to_world, Model& model) {
  Network network(maps, model);
  double last_fall = 0;
  bool converged = false;
  for (int step = 0; step < most_steps; ++step) {
    const bool afresh = last_fall == 0;
    if (!(afresh ? network.factor(model) : network.look_again(model))) return false;
    const double fall = network.step(model);
    if (!std::isfinite(fall)) return false;
    converged = fall <= negligible * network.variance();
    if (converged) break;
    to_world(model);
    last_fall = afresh || fall < least_fall_share * last_fall ? fall : 0;
  }
  if (!converged || std::any_of(maps.begin(), maps.end(), [&](const SubMap* map) { return bent(*map, model); }))
    return false;
  network.state_errors(model);
  return true;
}

}  // namespace ilp::model
