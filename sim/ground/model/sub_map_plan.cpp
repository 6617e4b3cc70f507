#include "sim/ground/model/sub_map_plan.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

namespace ilp::model {
namespace {

/// Keyframes that one passage gives to a sub-map, and all that it holds; those that only see its tracks not counted.
constexpr std::size_t most_of_passage = 12, least_of_map = 6, most_of_map = 72;
/// Keyframes of a strip that stand so near to each other in it relate by the flight's own tracks.
constexpr std::uint32_t passage_reach = 8;
/// Views that have fewer tracks in common tell too little of each other.
constexpr std::size_t least_common = 16;

class Groups {
 public:
  explicit Groups(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), std::uint32_t{0}); }

  std::uint32_t of(std::uint32_t one) {
    while (parent_[one] != one) one = parent_[one] = parent_[parent_[one]];
    return one;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t first = of(a), second = of(b);
    parent_[std::max(first, second)] = std::min(first, second);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

/// To which sub-map each view belongs.
class Assignment {
 public:
  Assignment(const Scene& scene, const TracksByView& seen_by, const std::vector<std::uint8_t>& wanted)
      : scene_(scene), seen_by_(seen_by), order_(scene.views.size()) {
    for (std::uint32_t v = 0; v < scene.views.size(); ++v) {
      order_[v] = next_in_strip_[scene.views[v].strip_id]++;
      map_of_.push_back(wanted[v] != 0 ? assign(v) : no_map);
    }
    dissolve_small_maps();
  }
  static constexpr std::uint32_t no_map = 0xffffffffU;

  /// That of most views that see it.
  [[nodiscard]] std::uint32_t map_of(const Track& track) const {
    std::uint32_t best = no_map;
    std::ptrdiff_t most = 0;
    for (const Sighting& one : track.seen) {
      const std::uint32_t map = map_of_[one.view];
      const auto count = std::count_if(track.seen.begin(), track.seen.end(),
                                       [&](const Sighting& seen) { return map_of_[seen.view] == map; });
      if (map == no_map || count < most || (count == most && map > best)) continue;
      most = count;
      best = map;
    }
    return best;
  }
  [[nodiscard]] std::size_t maps() const { return held_.size(); }

 private:
  /// Not as a neighbour in the strip.
  [[nodiscard]] bool sees_ground_again(std::uint32_t v, std::uint32_t earlier) const {
    return scene_.views[earlier].strip_id != scene_.views[v].strip_id || order_[v] - order_[earlier] > passage_reach;
  }

  /// The sub-map of those that have seen most of the view's ground before.
  [[nodiscard]] std::uint32_t map_seen_again(std::uint32_t v) const {
    std::map<std::uint32_t, std::size_t> common;
    for (const SeenTrack& seen_track : seen_by_[v]) {
      for (const Sighting& seen : scene_.tracks[seen_track.track].seen) {
        const std::uint32_t map = seen.view < v ? map_of_[seen.view] : no_map;
        if (map != no_map && sees_ground_again(v, seen.view)) ++common[map];
      }
    }
    return most_common(common).value_or(no_map);
  }

  static std::optional<std::uint32_t> most_common(const std::map<std::uint32_t, std::size_t>& common) {
    std::optional<std::uint32_t> best;
    std::size_t most = least_common - 1;
    for (const auto& [map, tracks] : common) {
      if (tracks <= most) continue;
      most = tracks;
      best = map;
    }
    return best;
  }

  /// Too few views leave their places in it uncertain. They join those with which they have most tracks in common.
  void dissolve_small_maps() {
    const std::vector<std::uint32_t> before = map_of_;
    for (std::uint32_t v = 0; v < before.size(); ++v) {
      if (before[v] == no_map || held_[before[v]] >= least_of_map) continue;
      std::map<std::uint32_t, std::size_t> common;
      for (const SeenTrack& seen_track : seen_by_[v]) {
        for (const Sighting& seen : scene_.tracks[seen_track.track].seen) {
          const std::uint32_t map = before[seen.view];
          if (map != no_map && held_[map] >= least_of_map) ++common[map];
        }
      }
      map_of_[v] = most_common(common).value_or(before[v]);
    }
  }

  [[nodiscard]] bool full(std::uint32_t map) const { return held_[map] >= most_of_map; }

  [[nodiscard]] std::uint32_t assign(std::uint32_t v) {
    Passage& passage = passages_[scene_.views[v].strip_id];
    const std::uint32_t again = map_seen_again(v);
    if (again != no_map && !full(again)) {
      passage = {again, 0};
    } else {
      // Where a full one ends, those beside it that have room would grow along its border.
      const bool beside = again != no_map && passage.count == 0;
      if (beside || passage.map == no_map || passage.count == most_of_passage || full(passage.map)) {
        passage = {static_cast<std::uint32_t>(held_.size()), 0};
        held_.push_back(0);
      }
      ++passage.count;
    }
    ++held_[passage.map];
    return passage.map;
  }

  /// Keyframes of a strip that follow each other over new ground, after one that saw ground again.
  struct Passage {
    std::uint32_t map = no_map;
    std::size_t count = 0;
  };
  const Scene& scene_;
  const TracksByView& seen_by_;
  std::vector<std::uint32_t> order_;  ///< in the strip, by view
  std::map<std::int64_t, std::uint32_t> next_in_strip_;
  std::map<std::int64_t, Passage> passages_;
  std::vector<std::uint32_t> map_of_;  ///< by view
  std::vector<std::size_t> held_;      ///< views, by map
};

/// The views that see the tracks, ascending.
std::vector<std::uint32_t> views_seeing(const Scene& scene, const std::vector<std::size_t>& tracks) {
  std::vector<std::uint8_t> seeing(scene.views.size(), 0);
  for (const std::size_t t : tracks) {
    for (const Sighting& seen : scene.tracks[t].seen) seeing[seen.view] = 1;
  }
  std::vector<std::uint32_t> views;
  for (std::uint32_t v = 0; v < seeing.size(); ++v) {
    if (seeing[v] != 0) views.push_back(v);
  }
  return views;
}

/// For views, by their places in a list of so many, those others with which they have enough tracks in common.
std::vector<std::vector<std::uint32_t>> neighbours(const Scene& scene, const std::vector<std::size_t>& tracks,
                                                   std::size_t views, const std::vector<std::uint32_t>& place) {
  std::vector<std::uint32_t> common(views * views, 0);
  std::vector<std::vector<std::uint32_t>> near(views);
  for (const std::size_t t : tracks) {
    const Sightings& seen = scene.tracks[t].seen;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const auto [a, b] = std::minmax(place[seen[i].view], place[seen[j].view]);
        if (b == views) continue;
        if (++common[a * views + b] != least_common) continue;
        near[a].push_back(b);
        near[b].push_back(a);
      }
    }
  }
  return near;
}

/// By view, whether it stays where views with fewer than two neighbours that stay are left out: nothing measures how
/// far such a view is from its only neighbour.
std::vector<std::uint8_t> with_two_neighbours(const std::vector<std::vector<std::uint32_t>>& near) {
  std::vector<std::uint8_t> stays(near.size(), 1);
  std::vector<std::size_t> left(near.size());
  std::vector<std::uint32_t> leaving;
  for (std::uint32_t v = 0; v < near.size(); ++v) {
    left[v] = near[v].size();
    if (left[v] < 2) leaving.push_back(v);
  }
  while (!leaving.empty()) {
    const std::uint32_t v = leaving.back();
    leaving.pop_back();
    stays[v] = 0;
    for (const std::uint32_t other : near[v]) {
      if (--left[other] == 1 && stays[other] != 0) leaving.push_back(other);
    }
  }
  return stays;
}

/// The tracks and views of one sub-map as it is divided.
struct Division {
  std::vector<std::size_t> tracks, support;
  std::vector<std::uint32_t> views;              ///< that see the tracks, ascending
  std::vector<std::uint32_t> place;              ///< in `views`, by view of the scene; its size: none
  std::vector<std::vector<std::uint32_t>> near;  ///< by place
  std::vector<std::uint8_t> stays;               ///< by place
};

/// Views of which the tracks alone tell too little, but that have something in common with others, are supported by
/// the tracks that they see together with views of the sub-map.
void add_support(const Scene& scene, const TracksByView& seen_by, Division& division) {
  const auto in_map = [&](std::uint32_t view) {
    const std::uint32_t place = division.place[view];
    return place < division.views.size() && !division.near[place].empty();
  };
  for (std::uint32_t i = 0; i < division.views.size(); ++i) {
    if (division.stays[i] != 0 || division.near[i].empty()) continue;
    for (const SeenTrack& seen_track : seen_by[division.views[i]]) {
      const Sightings& seen = scene.tracks[seen_track.track].seen;
      const auto common = std::count_if(seen.begin(), seen.end(), [&](const Sighting& s) { return in_map(s.view); });
      if (common > 1 && !std::binary_search(division.tracks.begin(), division.tracks.end(), seen_track.track))
        division.support.push_back(seen_track.track);
    }
  }
  std::sort(division.support.begin(), division.support.end());
  division.support.erase(std::unique(division.support.begin(), division.support.end()), division.support.end());
}

Division division_of(const Scene& scene, const TracksByView& seen_by, const std::vector<std::size_t>& tracks) {
  Division division;
  division.tracks = tracks;
  division.views = views_seeing(scene, tracks);
  const std::size_t count = division.views.size();
  division.place.assign(scene.views.size(), static_cast<std::uint32_t>(count));
  for (std::uint32_t i = 0; i < count; ++i) division.place[division.views[i]] = i;
  division.near = neighbours(scene, tracks, count, division.place);
  division.stays = with_two_neighbours(division.near);
  add_support(scene, seen_by, division);
  if (division.support.empty()) return division;
  std::vector<std::size_t> all = tracks;
  all.insert(all.end(), division.support.begin(), division.support.end());
  // Without own tracks in common with any other, a view does not become one of the sub-map.
  const auto near_by_own = std::move(division.near);
  division.near = neighbours(scene, all, count, division.place);
  for (std::uint32_t i = 0; i < count; ++i) {
    if (near_by_own[i].empty()) division.near[i].clear();
    std::erase_if(division.near[i], [&](std::uint32_t other) { return near_by_own[other].empty(); });
  }
  division.stays = with_two_neighbours(division.near);
  return division;
}

/// Gives each track to the group of views that has two of its sightings first.
void share_out(const Scene& scene, const Division& division, const std::vector<std::uint32_t>& group,
               const std::vector<std::size_t>& tracks, const std::function<void(std::uint32_t, std::size_t)>& give) {
  for (const std::size_t t : tracks) {
    std::map<std::uint32_t, std::size_t> sightings;  // by group
    for (const Sighting& seen : scene.tracks[t].seen) {
      const std::uint32_t place = division.place[seen.view];
      if (place == division.views.size() || division.stays[place] == 0 || ++sightings[group[place]] < 2) continue;
      give(group[place], t);
      break;
    }
  }
}

/// Views that nothing places in the sub-map belong to no plan, and views that are not connected to different ones.
void divide(const Scene& scene, const TracksByView& seen_by, const std::vector<std::size_t>& tracks,
            std::vector<SubMapPlan>& plans) {
  const Division division = division_of(scene, seen_by, tracks);
  const std::size_t count = division.views.size();
  Groups groups(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    for (const std::uint32_t other : division.near[i]) {
      if (division.stays[i] != 0 && division.stays[other] != 0) groups.join(i, other);
    }
  }
  std::vector<std::size_t> plan_of(count, 0);
  std::vector<std::uint32_t> group;
  for (std::uint32_t i = 0; i < count; ++i) {
    group.push_back(groups.of(i));
    if (division.stays[i] == 0) continue;
    if (group[i] == i) {
      plan_of[i] = plans.size();
      plans.emplace_back();
    }
    plans[plan_of[group[i]]].views.push_back(division.views[i]);
  }
  share_out(scene, division, group, division.tracks,
            [&](std::uint32_t of, std::size_t t) { plans[plan_of[of]].tracks.push_back(t); });
  share_out(scene, division, group, division.support,
            [&](std::uint32_t of, std::size_t t) { plans[plan_of[of]].support.push_back(t); });
}

}  // namespace

std::vector<std::uint8_t> connected_views(const Scene& scene, std::uint32_t with) {
  Groups groups(scene.views.size());
  std::map<std::int64_t, std::uint32_t> first_of_strip;
  for (std::uint32_t v = 0; v < scene.views.size(); ++v) {
    if (scene.views[v].posed) groups.join(first_of_strip.try_emplace(scene.views[v].strip_id, v).first->second, v);
  }
  for (const Track& track : scene.tracks) {
    for (const Sighting& seen : track.seen) groups.join(track.seen.front().view, seen.view);
  }
  std::vector<std::uint8_t> connected;
  for (std::uint32_t v = 0; v < scene.views.size(); ++v) connected.push_back(groups.of(v) == groups.of(with) ? 1 : 0);
  return connected;
}

std::vector<SubMapPlan> plan_sub_maps(const Scene& scene, const std::vector<std::uint8_t>& wanted) {
  const TracksByView seen_by = tracks_by_view(scene);
  const Assignment assignment(scene, seen_by, wanted);
  std::vector<std::vector<std::size_t>> tracks(assignment.maps());
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    if (scene.tracks[t].seen.size() < 2) continue;
    const std::uint32_t map = assignment.map_of(scene.tracks[t]);
    if (map != Assignment::no_map) tracks[map].push_back(t);
  }
  std::vector<SubMapPlan> plans;
  for (const auto& of_map : tracks) divide(scene, seen_by, of_map, plans);
  return plans;
}

}  // namespace ilp::model
