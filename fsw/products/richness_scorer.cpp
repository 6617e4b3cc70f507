#include "fsw/products/richness_scorer.hpp"

#include "fsw/base/vector_width.hpp"
#include "fsw/shared/frame_access.hpp"
#include "fsw/vision/terrain/depth_coding.hpp"
#include "fsw/vision/terrain/sigma_map.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr float px_per_sigma_code = 1.0F / static_cast<float>(sigma_codes_per_px);

double squash(const CueScale& scale, double cue) {
  return cue / (cue + scale.half);
}

void decode_sigma(const std::uint16_t* codes, const std::uint8_t* sigma_codes, std::size_t count, float unit,
                  float* __restrict sigma) {
  for (std::size_t i = 0; i < count; ++i) {
    // A supported depth has no relief of its own.
    const bool measured = (codes[i] != 0) & (sigma_codes[i] <= sigma_code_largest);
    const float value = static_cast<float>(static_cast<std::int32_t>(sigma_codes[i])) * unit;
    sigma[i] = measured ? value : 0.0F;
  }
}

void fill(const RichnessCues& cues, const RichnessParams& params, RichnessRecord& record) {
  record.gradient_fine = squash(params.gradient_fine, cues.gradient_fine);
  record.gradient_coarse = squash(params.gradient_coarse, cues.gradient_coarse);
  record.entropy = squash(params.entropy, cues.entropy);
  record.contrast = squash(params.contrast, cues.contrast);
  record.relief = squash(params.relief, cues.relief);
  record.slope_steep = squash(params.slope_steep, cues.slope_steep);
  record.slope_excess = squash(params.slope_excess, cues.slope_excess);
  record.roughness_fine = squash(params.roughness_fine, cues.roughness_fine);
  record.roughness_coarse = squash(params.roughness_coarse, cues.roughness_coarse);
  record.curvature = squash(params.curvature, cues.curvature);
  record.novelty = squash(params.novelty, cues.novelty);
  record.mask_fraction = cues.mask_fraction;
  record.has_terrain = cues.has_terrain;
}

}  // namespace

RichnessParams richness_params(const MissionParameters& mission) {
  RichnessParams params;
  params.gradient_fine = {mission.gradient_fine_half, mission.gradient_fine_weight};
  params.gradient_coarse = {mission.gradient_coarse_half, mission.gradient_coarse_weight};
  params.entropy = {mission.entropy_half, mission.entropy_weight};
  params.contrast = {mission.contrast_half, mission.contrast_weight};
  params.relief = {mission.relief_half, mission.relief_weight};
  params.slope_steep = {mission.slope_steep_half, mission.slope_steep_weight};
  params.slope_excess = {mission.slope_excess_half, mission.slope_excess_weight};
  params.roughness_fine = {mission.roughness_fine_half, mission.roughness_fine_weight};
  params.roughness_coarse = {mission.roughness_coarse_half, mission.roughness_coarse_weight};
  params.curvature = {mission.curvature_half, mission.curvature_weight};
  params.novelty = {mission.novelty_half, mission.novelty_weight};
  params.novelty_memory = mission.novelty_memory_images;
  params.noise_grey = mission.sensor_noise_grey;
  return params;
}

constexpr CheckpointForm RichnessScorer::checkpoint = checkpoint_form<State>(component_id);

RichnessScorer::RichnessScorer(Tables store, const MissionParameters& mission, Scratch scratch)
    : wiring_{store, mission, scratch} {}

Status RichnessScorer::restore() {
  work_.phase = Phase::idle;
  const Status status = restore_checkpoint(wiring_.store, checkpoint, cursor_, state_);
  if (!restored(status)) return status;
  std::int64_t newest = 0;
  ILP_TRY(newest_id<RichnessRecord>(wiring_.store, newest));
  cursor_.first = std::max(cursor_.first, newest);
  return status;
}

Status RichnessScorer::load_image() {
  ILP_TRY(load_camera(wiring_.store, work_.camera));
  return load_keyframe_image(wiring_.store, work_.depth.id, wiring_.scratch.as<Workspace>().image);
}

Status RichnessScorer::decode_maps() {
  auto& w = wiring_.scratch.as<Workspace>();
  ILP_TRY(w.inverse_depth.resize(work_.depth.width, work_.depth.height));
  ILP_TRY(w.sigma.resize(work_.depth.width, work_.depth.height));
  // Without depth every code is 0 and any coding reads them.
  const DepthCoding coding{work_.depth.offset, work_.depth.verdict == DepthVerdict::ok ? work_.depth.step : 1.0};
  ILP_TRY(decode_depth(w.maps.codes.view(), coding, w.inverse_depth.view()));
  const ImageView<const std::uint16_t> codes = w.maps.codes.view();
  const double per_px =
      work_.depth.disparity_per_inverse_depth_px > 0 ? 1.0 / work_.depth.disparity_per_inverse_depth_px : 0;
  const float unit = static_cast<float>(per_px) * px_per_sigma_code;
  with_widest_vectors(
      [&] { decode_sigma(codes.data, w.maps.sigma.view().data, codes.area(), unit, w.sigma.view().data); });
  begin_richness(w.richness, w.cues);
  return {};
}

Status RichnessScorer::score() {
  auto& w = wiring_.scratch.as<Workspace>();
  const RichnessParams params = richness_params(wiring_.mission);
  double index = 0;
  ILP_TAKE(const bool more,
           score_richness_slice(work_.camera, w.image.view(), w.inverse_depth.view(), w.sigma.view(),
                                w.maps.mask.view(), params, state_.history, w.richness, w.cues, index));
  if (more) return {};
  work_.record.richness = index;
  work_.record.images_learned = state_.history.count;
  fill(w.cues, params, work_.record);
  work_.phase = Phase::record;
  return {};
}

Status RichnessScorer::advance() {
  switch (work_.phase) {
    case Phase::image:
      work_.phase = Phase::maps;
      return load_image();
    case Phase::maps:
      work_.phase = Phase::depth;
      return load_maps(wiring_.store, work_.depth, work_.mask, wiring_.scratch.as<Workspace>().maps);
    case Phase::depth:
      work_.phase = Phase::cues;
      return decode_maps();
    case Phase::cues:
      return score();
    case Phase::idle:
    case Phase::record:
      break;
  }
  return {};
}

StepResult RichnessScorer::record(const Status& scored) {
  work_.phase = Phase::idle;
  State after = state_;
  if (scored.ok() && !work_.patience.abandoned(work_.depth.id)) {
    learn(wiring_.scratch.as<Workspace>().cues, richness_params(wiring_.mission), after.history);
  }
  StepTransaction transaction(wiring_.store, checkpoint);
  Status status = transaction.begin();
  if (status.ok()) status = put(wiring_.store, work_.record);
  if (status.ok()) status = transaction.commit({work_.depth.id, cursor_.second}, after, cursor_, state_);
  if (!status.ok()) return {status, false};
  return {scored, true};
}

StepResult RichnessScorer::pick() {
  const Status found = next(wiring_.store, cursor_.first, work_.depth);
  if (found.is(StatusCode::not_found)) return {};
  const bool damaged = found.is(StatusCode::record_damaged);
  if (damaged) {
    work_.depth = {};
    work_.depth.id = found.a;
  }
  if (!found.ok() && !damaged) return {found, false};
  // Until then it may still lose ground that was seen before. Without a mask that can be read nothing has to be
  // awaited.
  work_.mask = {};
  const Status masked = get(wiring_.store, work_.depth.id, work_.mask);
  const bool abandoned = work_.patience.abandoned(work_.depth.id);
  if (!masked.ok() && !is_gone(masked) && !abandoned) return work_.patience.failed(work_.depth.id, masked);
  if (masked.ok() && work_.mask.scope != MaskScope::flight) return {};
  work_.record = {};
  work_.record.id = work_.depth.id;
  work_.record.strip_id = work_.depth.strip_id;
  if (damaged || abandoned) return record(found);
  work_.phase = Phase::image;
  return {{}, true, Then::keep};
}

StepResult RichnessScorer::step() {
  if (wiring_.mission.safe_mode) work_.phase = Phase::idle;
  if (wiring_.mission.safe_mode) return {};
  if (work_.phase == Phase::idle) return pick();
  if (work_.phase == Phase::record) return record({});
  const Status status = advance();
  if (status.ok()) return {{}, true, Then::keep};
  return is_transient(status) ? work_.patience.failed(work_.depth.id, status) : record(status);
}

}  // namespace ilp
