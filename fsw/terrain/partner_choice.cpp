#include "fsw/terrain/partner_choice.hpp"

namespace ilp {
namespace {

constexpr double small_share = 0.125;  // of the largest sigma: a better partner would gain little

StepCovariance step_to(const PoseRecord& pose) {
  StepCovariance step;
  for (int i = 0; i < StepCovariance::elements; ++i) step.lower[i] = pose.step_covariance[i];
  return step;
}

RigidTransform between(const PoseRecord& from, const PoseRecord& to) {
  return compose(cam_from_world(pose_of(to)), inverse(cam_from_world(pose_of(from))));
}

/// In the middle of the inverse depths.
double distance_of(const PoseRecord& pose) {
  const bool known = pose.min_depth > 0 && pose.max_depth > 0;
  return known ? 2 / (1 / pose.min_depth + 1 / pose.max_depth) : 0;
}

struct Search {
  Reader<PoseRecord, StripRecord> store;
  const CameraModel& camera;
  const PoseRecord &pose, &next;
  const Coverage& coverage;
  std::uint32_t reach;
};

Result<Successor> search_partner(const Search& search, const PairUtilityParams& params, Partner& partner) {
  Partner candidate = partner_of(search.next, params.finer_steps);
  partner = candidate;
  const double distance = distance_of(search.pose);
  RigidTransform candidate_from_this = between(search.pose, candidate.pose);
  PairUtility best = pair_utility(search.camera, candidate_from_this, distance, search.coverage, params);
  if (best.median_sigma <= small_share * params.largest_sigma) return Successor::final;
  for (std::uint32_t place = 1; place < search.reach; ++place) {
    PoseRecord further;
    ILP_TAKE(const Successor found, next_with_pose(search.store, search.pose, candidate.pose.id, further));
    if (found == Successor::not_yet) return found;
    partner.at_end = found == Successor::none;
    if (partner.at_end) return Successor::final;
    const RigidTransform step = between(candidate.pose, further);
    candidate.step = joined_steps(candidate_from_this, candidate.step, step, step_to(further));
    candidate.pose = further;
    candidate_from_this = compose(step, candidate_from_this);
    const PairUtility promised = pair_utility(search.camera, candidate_from_this, distance, search.coverage, params);
    if (promised.utility <= best.utility) continue;
    best = promised;
    partner = candidate;
  }
  return Successor::final;
}

}  // namespace

Partner partner_of(const PoseRecord& next, std::int32_t finer_steps) {
  return {next, step_to(next), false, finer_steps};
}

Result<Successor> next_with_pose(Reader<PoseRecord, StripRecord> store, const PoseRecord& pose, std::int64_t after_id,
                                 PoseRecord& successor) {
  StripRecord strip;
  const Status known = get(store, pose.strip_id, strip);
  // A damaged one is written again with the next keyframe or the strip's end.
  if (!known.ok() && !known.is(StatusCode::record_damaged)) return known;
  for (std::int64_t id = after_id + 1;; ++id) {  // bound: the poses after this one
    const Status found = get(store, id, successor);
    if (found.is(StatusCode::not_found)) {
      const bool ended = strip.end != StripEnd::open && strip.last_keyframe_id < id;
      return ended ? Successor::none : Successor::not_yet;
    }
    if (found.is(StatusCode::record_damaged)) continue;
    ILP_TRY(found);
    if (successor.strip_id != pose.strip_id) return Successor::none;
    if (successor.state == PoseState::failed) continue;
    return successor.state == PoseState::final ? Successor::final : Successor::not_yet;
  }
}

Result<Successor> choose_partner(Reader<PoseRecord, StripRecord> store, const CameraModel& camera,
                                 const PoseRecord& pose, const PoseRecord& next, const Coverage& coverage,
                                 const PairUtilityParams& params, std::uint32_t reach, Partner& partner) {
  const Search search{store, camera, pose, next, coverage, reach};
  ILP_TAKE(const Successor found, search_partner(search, params, partner));
  if (found != Successor::final || !partner.at_end) return found;
  PairUtilityParams at_end = params;
  at_end.finer_steps = finer_steps_at_end;
  return search_partner(search, at_end, partner);
}

}  // namespace ilp
