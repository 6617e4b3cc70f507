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

class Relating {
 public:
  explicit Relating(const Scene& of) : scene(of) {}

  /// The same as relate(), whose answer is kept.
  bool relate_once(PairRelation& relation) const {
    if (scene.results == nullptr) return relate(relation);
    const std::uint64_t digest = intake::InputDigest("verified place 1")
                                     .add_value(scene.views[relation.a].features_digest)
                                     .add_value(scene.views[relation.b].features_digest)
                                     .value();
    std::vector<double> plane;
    if (const auto known = scene.results->result(digest)) {
      std::span<const std::uint8_t> bytes = *known;
      if (intake::take(bytes, plane) && (plane.empty() || plane.size() == std::size(relation.plane_b_from_a))) {
        std::copy(plane.begin(), plane.end(), relation.plane_b_from_a);
        return !plane.empty();
      }
    }
    const bool related = relate(relation);
    if (related) plane.assign(std::begin(relation.plane_b_from_a), std::end(relation.plane_b_from_a));
    std::vector<std::uint8_t> bytes;
    intake::append(plane, bytes);
    scene.results->put_result(digest, bytes);
    return related;
  }

 private:
  bool relate(PairRelation& relation) const {
    thread_local const auto workspace = std::make_unique<PlaceMatchWorkspace>();
    thread_local PlaceMatch match;
    const std::vector<PlaceFeature>&a = scene.views[relation.a].features, &b = scene.views[relation.b].features;
    const Status status =
        verify_place({a.data(), a.size()}, {b.data(), b.size()}, least_place_evidence, *workspace, match);
    if (!status.ok() || match.verdict != PlaceVerdict::verified) return false;
    const Mat3 plane = matrix_of(match.plane_newer_from_older);
    if (!invertible(plane)) return false;
    set_plane(plane, relation);
    return true;
  }

  const Scene& scene;
};

MatcherParams params_of(const PairRelation& relation) {
  MatcherParams params;
  params.search_radius_px = relation.radius_px;
  params.min_score = min_score;
  return params;
}

std::uint64_t digest_of(const PairRelation& relation, const Scene& scene) {
  const View &a = scene.views[relation.a], &b = scene.views[relation.b];
  intake::InputDigest digest("matched corners 1");
  for (const View* view : {&a, &b}) digest.add_value(view->image_digest).add_value(view->corners_digest);
  for (const double h : relation.plane_b_from_a) digest.add_value(h);
  return digest.add_value(relation.radius_px).add_value(min_score).value();
}

/// As the matcher takes them.
struct CornersOfPair {
  Corners a, b;

  static void copy(const std::vector<Corner>& from, Corners& to) {
    to.clear();
    for (const Corner& corner : from) (void)to.push_back(corner);
  }
};

Matches matches_of(const PairRelation& relation, const Scene& scene) {
  thread_local const auto corners = std::make_unique<CornersOfPair>();
  thread_local const auto workspace = std::make_unique<MatcherWorkspace>();
  const View &a = scene.views[relation.a], &b = scene.views[relation.b];
  const MatcherParams params = params_of(relation);
  CornersOfPair::copy(a.corners, corners->a);
  CornersOfPair::copy(b.corners, corners->b);
  Matches matches;
  if (!match_corners_by_plane(a.image.view(), corners->a, b.image.view(), corners->b, relation.plane_b_from_a, params,
                              *workspace, matches)
           .ok()) {
    matches.clear();
  }
  return matches;
}

/// Those that are kept are not matched again, and their images not decoded.
std::vector<Matches> matches_of_all(const std::vector<PairRelation>& relations, Scene& scene) {
  std::vector<Matches> matches(relations.size());
  std::vector<std::uint64_t> digests(relations.size());
  std::vector<std::size_t> fresh;
  std::set<std::uint32_t> needed;
  for (std::size_t i = 0; i < relations.size(); ++i) {
    digests[i] = digest_of(relations[i], scene);
    const auto known = scene.results == nullptr ? std::nullopt : scene.results->result(digests[i]);
    std::span<const std::uint8_t> bytes;
    if (known) bytes = *known;
    if (known && intake::take(bytes, matches[i])) continue;
    fresh.push_back(i);
    needed.insert({relations[i].a, relations[i].b});
  }
  load_images({needed.begin(), needed.end()}, scene);
  host::for_each_parallel(fresh.size(), [&](std::size_t k) {
    const std::size_t i = fresh[k];
    matches[i] = matches_of(relations[i], scene);
    if (scene.results == nullptr) return;
    std::vector<std::uint8_t> bytes;
    intake::append(matches[i], bytes);
    scene.results->put_result(digests[i], bytes);
  });
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

std::vector<std::uint8_t> weakly_connected_views(const Scene& scene) {
  std::map<std::int64_t, std::size_t> poses;
  for (const View& view : scene.views) poses[view.strip_id] += view.posed ? 1 : 0;
  std::vector<std::uint8_t> weak;
  for (const View& view : scene.views) weak.push_back(!view.posed || poses[view.strip_id] < few_poses ? 1 : 0);
  return weak;
}

std::vector<PairRelation> relations_by_links(const intake::Flight& flight, const Scene& scene) {
  const std::vector<std::uint8_t> weak = weakly_connected_views(scene);
  std::vector<PairRelation> relations;
  Pairs related;
  for (const LinkRecord& link : flight.links) {
    const std::int32_t place = scene.view_of(link.place_id), newer = scene.view_of(link.keyframe_id);
    if (place < 0 || newer < 0 || place >= newer) continue;
    PairRelation relation;
    relation.a = static_cast<std::uint32_t>(place);
    relation.b = static_cast<std::uint32_t>(newer);
    const Mat3 plane = matrix_of(link.keyframe_from_place_px);
    if (weak[relation.a] == 0 && weak[relation.b] == 0) continue;
    const bool images = scene.views[relation.a].has_image && scene.views[relation.b].has_image;
    if (!images || !invertible(plane) || !related.emplace(relation.a, relation.b).second) continue;
    set_plane(plane, relation);
    relations.push_back(relation);
  }
  return relations;
}

std::vector<PairRelation> relations_by_features(const Scene& scene, const std::vector<PairRelation>& known) {
  Pairs pairs, related_already;
  for (const PairRelation& relation : known) related_already.emplace(relation.a, relation.b);
  const std::vector<std::uint8_t> weak = weakly_connected_views(scene);
  for (std::uint32_t one = 0; one < scene.views.size(); ++one) {
    for (std::uint32_t other = 0; weak[one] != 0 && other < scene.views.size(); ++other) {
      const View &x = scene.views[one], &y = scene.views[other];
      if (other == one || !x.has_image || !y.has_image) continue;
      if (x.posed && y.posed && x.strip_id == y.strip_id) continue;
      const auto [a, b] = std::minmax(one, other);
      if (!related_already.contains({a, b})) pairs.emplace(a, b);
    }
  }
  std::vector<PairRelation> candidates;
  for (const auto& [a, b] : pairs) candidates.push_back({a, b});
  std::vector<std::uint8_t> related(candidates.size());
  const Relating relating{scene};
  host::for_each_parallel(candidates.size(), [&](std::size_t i) { related[i] = relating.relate_once(candidates[i]); });
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
  const std::vector<Matches> matches = matches_of_all(relations, scene);
  for (std::size_t i = 0; i < relations.size(); ++i) add_sightings(relations[i], matches[i], scene);
}

}  // namespace ilp::model
