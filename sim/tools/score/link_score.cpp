#include "sim/tools/score/link_score.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace ilp::score {
namespace {

bool common(const KeyframeTruth& a, const KeyframeTruth& b) {
  return world::true_overlap(*a.frame, *b.frame) >= LinkScore::common_ground &&
         world::true_overlap(*b.frame, *a.frame) >= LinkScore::common_ground;
}

/// Ids of the earlier keyframes whose ground the last member sees again.
std::vector<std::int64_t> seen_again(std::span<const KeyframeTruth> members) {
  const KeyframeTruth& newer = members.back();
  std::vector<std::int64_t> ids;
  bool in_view = true;
  for (std::size_t k = members.size() - 1; k-- > 0;) {
    in_view = in_view && members[k].keyframe->strip_id == newer.keyframe->strip_id;
    if (!common(newer, members[k])) {
      in_view = false;
    } else if (!in_view) {
      ids.push_back(members[k].keyframe->id);
    }
  }
  return ids;
}

bool sees_nothing_of_each_other(const world::TrueFrame* a, const world::TrueFrame* b) {
  return a != nullptr && b != nullptr && world::true_overlap(*a, *b) <= 0 && world::true_overlap(*b, *a) <= 0;
}

}  // namespace

std::vector<LinkedPair> links_of(const intake::Flight& flight) {
  std::vector<LinkedPair> links;
  for (const LinkRecord& link : flight.links) links.push_back({link.keyframe_id, link.place_id});
  return links;
}

LinkScore score_links(const intake::Flight& flight, std::span<const LinkedPair> links, TrueFrames& truth) {
  LinkScore score;
  std::set<std::pair<std::int64_t, std::int64_t>> linked;
  const auto frame_of = [&](std::int64_t id) {
    const auto found = flight.keyframes.find(id);
    return found == flight.keyframes.end() ? nullptr : truth.sampled(found->second.name);
  };
  for (const LinkedPair& link : links) {
    const world::TrueFrame* a = frame_of(link.newer);
    const world::TrueFrame* b = frame_of(link.older);
    if (a == nullptr || b == nullptr) continue;
    linked.emplace(link.newer, link.older);
    ++score.links;
    score.false_links += sees_nothing_of_each_other(a, b) ? 1U : 0U;
  }
  const std::vector<KeyframeTruth> members = keyframes_with_truth(flight, truth);
  score.keyframes = members.size();
  for (std::size_t k = 1; k < members.size(); ++k) {
    const std::vector<std::int64_t> again = seen_again(std::span(members).first(k + 1));
    const auto found = static_cast<std::size_t>(std::count_if(again.begin(), again.end(), [&](std::int64_t older) {
      return linked.contains({members[k].keyframe->id, older});
    }));
    score.pairs += again.size();
    score.pairs_linked += found;
    score.returned += again.empty() ? 0U : 1U;
    score.linked += found > 0 ? 1U : 0U;
  }
  return score;
}

}  // namespace ilp::score
