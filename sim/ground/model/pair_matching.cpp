#include "sim/ground/model/pair_matching.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "fsw/vision/features/matcher.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/place/place_match_workspace.hpp"
#include "fsw/vision/place/place_verification.hpp"
#include "sim/host/parallel.hpp"

namespace ilp::model {
namespace {

/// Strips of fewer poses have little ground of their own by which the flight could have linked them.
constexpr std::size_t few_poses = 8;
/// Decoded images differ by their coding as well.
constexpr float min_score = 0.72F;

bool invertible(const Mat3& h) {
  return h.allFinite() && std::fabs(h(2, 2)) > 1e-9 &&
         std::fabs(h.determinant()) > 1e-9 * std::pow(std::fabs(h(2, 2)), 3);
}

void set_plane(Mat3 plane_b_from_a, PairRelation& relation) {
  plane_b_from_a /= plane_b_from_a(2, 2);
  for (int i = 0; i < 9; ++i) relation.plane_b_from_a[i] = plane_b_from_a(i / 3, i % 3);
}

Mat3 matrix_of(const double (&rows)[9]) {
  Mat3 m;
  for (int i = 0; i < 9; ++i) m(i / 3, i % 3) = rows[i];
  return m;
}

using Pairs = std::set<std::pair<std::uint32_t, std::uint32_t>>;

struct Relating {
  const Scene& scene;

  bool relate(PairRelation& relation) const {
    thread_local const auto workspace = std::make_unique<PlaceMatchWorkspace>();
    thread_local PlaceMatch match;
    const PlaceFeatures &a = scene.views[relation.a].features, &b = scene.views[relation.b].features;
    const Status status = verify_place({a.data(), a.size()}, {b.data(), b.size()}, {}, *workspace, match);
    if (!status.ok() || match.verdict != PlaceVerdict::verified) return false;
    const Mat3 plane = matrix_of(match.plane_newer_from_older);
    if (!invertible(plane)) return false;
    set_plane(plane, relation);
    return true;
  }
};

Matches matches_of(const PairRelation& relation, const Scene& scene) {
  thread_local const auto workspace = std::make_unique<MatcherWorkspace>();
  const View &a = scene.views[relation.a], &b = scene.views[relation.b];
  MatcherParams params;
  params.search_radius_px = relation.radius_px;
  params.min_score = min_score;
  Matches matches;
  if (!match_corners_by_plane(a.image.view(), a.corners, b.image.view(), b.corners, relation.plane_b_from_a, params,
                              *workspace, matches)
           .ok()) {
    matches.clear();
  }
  return matches;
}

void add_sightings(const PairRelation& relation, const Matches& matches, Scene& scene) {
  View& a = scene.views[relation.a];
  const View& b = scene.views[relation.b];
  for (const Match& match : matches) {
    std::int32_t& number = a.track_of_corner[match.a];
    if (number < 0) {
      number = static_cast<std::int32_t>(scene.tracks.size());
      const Vec2 own = ideal_from_pixel(a.camera, Vec2(a.corners[match.a].x, a.corners[match.a].y));
      scene.tracks.push_back({false, 0, Vec3::Zero(), {{relation.a, own.x(), own.y()}}});
    }
    Track& track = scene.tracks[static_cast<std::size_t>(number)];
    if (scene.sighting(track, relation.b) != nullptr) continue;
    const Vec2 other = ideal_from_pixel(b.camera, Vec2(match.xb, match.yb));
    track.seen.push_back({relation.b, other.x(), other.y()});
  }
}

}  // namespace

std::vector<std::uint8_t> loose_views(const Scene& scene) {
  std::map<std::int64_t, std::size_t> poses;
  for (const View& view : scene.views) poses[view.strip_id] += view.posed ? 1 : 0;
  std::vector<std::uint8_t> loose;
  for (const View& view : scene.views) loose.push_back(!view.posed || poses[view.strip_id] < few_poses ? 1 : 0);
  return loose;
}

std::vector<PairRelation> relations_by_links(const intake::Flight& flight, const Scene& scene) {
  const std::vector<std::uint8_t> loose = loose_views(scene);
  std::vector<PairRelation> relations;
  Pairs related;
  for (const LinkRecord& link : flight.links) {
    const std::int32_t place = scene.view_of(link.place_id), newer = scene.view_of(link.keyframe_id);
    if (place < 0 || newer < 0 || place >= newer) continue;
    PairRelation relation;
    relation.a = static_cast<std::uint32_t>(place);
    relation.b = static_cast<std::uint32_t>(newer);
    const Mat3 plane = matrix_of(link.keyframe_from_place_px);
    if (loose[relation.a] == 0 && loose[relation.b] == 0) continue;
    const bool images = !scene.views[relation.a].image.empty() && !scene.views[relation.b].image.empty();
    if (!images || !invertible(plane) || !related.emplace(relation.a, relation.b).second) continue;
    set_plane(plane, relation);
    relations.push_back(relation);
  }
  return relations;
}

std::vector<PairRelation> relations_by_features(const Scene& scene, const std::vector<PairRelation>& known) {
  Pairs pairs, related_already;
  for (const PairRelation& relation : known) related_already.emplace(relation.a, relation.b);
  const std::vector<std::uint8_t> loose = loose_views(scene);
  for (std::uint32_t one = 0; one < scene.views.size(); ++one) {
    for (std::uint32_t other = 0; loose[one] != 0 && other < scene.views.size(); ++other) {
      const View &x = scene.views[one], &y = scene.views[other];
      if (other == one || x.image.empty() || y.image.empty()) continue;
      if (x.posed && y.posed && x.strip_id == y.strip_id) continue;
      const auto [a, b] = std::minmax(one, other);
      if (!related_already.contains({a, b})) pairs.emplace(a, b);
    }
  }
  std::vector<PairRelation> candidates;
  for (const auto& [a, b] : pairs) candidates.push_back({a, b});
  std::vector<std::uint8_t> related(candidates.size());
  const Relating relating{scene};
  host::for_each_parallel(candidates.size(), [&](std::size_t i) { related[i] = relating.relate(candidates[i]); });
  std::vector<PairRelation> relations;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (related[i] != 0) relations.push_back(candidates[i]);
  }
  return relations;
}

void match_pairs(const std::vector<PairRelation>& pairs, Scene& scene) {
  // A match says where the corner of one image lies in the other to a few hundredths of a pixel, and not the reverse.
  std::vector<PairRelation> relations;
  for (const PairRelation& pair : pairs) {
    relations.push_back(pair);
    PairRelation reverse = pair;
    std::swap(reverse.a, reverse.b);
    set_plane(matrix_of(pair.plane_b_from_a).inverse(), reverse);
    relations.push_back(reverse);
  }
  std::vector<Matches> matches(relations.size());
  host::for_each_parallel(relations.size(), [&](std::size_t i) { matches[i] = matches_of(relations[i], scene); });
  for (std::size_t i = 0; i < relations.size(); ++i) add_sightings(relations[i], matches[i], scene);
}

}  // namespace ilp::model
