#include "fsw/products/compressor.hpp"

#include <algorithm>

#include "fsw/base/argument.hpp"
#include "fsw/shared/camera_on_record.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/shared/frame_access.hpp"

namespace ilp {
namespace {

// Finer than an image's, so that the requested error is met with few extra bytes.
constexpr double depth_layer_ratio = 0.7;

// The intervals of single keyframes vary too much to say how narrow the link is.
constexpr std::int64_t mean_keyframes = 10;

}  // namespace

constexpr CheckpointForm Compressor::checkpoint = checkpoint_form<State>(component_id);

Compressor::Compressor(Tables store, const MissionParameters& mission, Scratch scratch, Worker* worker)
    : wiring_{store, mission, scratch, worker != nullptr ? worker : &workspace_.inline_worker} {}

Status Compressor::restore() {
  // Whatever the flags were, the worker says whether it still has the memory of the job.
  work_.handed_over = true;
  work_.wanted = work_.stuck = work_.loaded = false;
  work_.coded_mask_checksum = 0;
  const Status status = restore_checkpoint(wiring_.store, checkpoint, cursor_, state_);
  if (!restored(status)) return status;
  // A product on record was made. A product that the ground holds has left the store, and its keyframe with it.
  ProductRecord newest;
  ILP_TAKE(const bool found, found_by(last(wiring_.store, newest)));
  if (found && newest.keyframe_id > cursor_.first) {
    const bool image = newest.kind == ProductKind::image;
    if (newest.keyframe_id > cursor_.second) cursor_.second = newest.keyframe_id;
    cursor_.first = std::max(cursor_.first, image ? newest.keyframe_id : newest.keyframe_id - 1);
  }
  return status;
}

/// Loads what the product needs of the maps. If it cannot be read, all of the image counts as new.
Status Compressor::load_depth(std::int64_t keyframe_id, ProductKind kind, Status& damage) {
  damage = get(wiring_.store, keyframe_id, work_.subject.depth);
  if (damage.ok()) damage = get(wiring_.store, keyframe_id, work_.subject.mask);
  // A keyframe's second product has the mask of its first one.
  const DecodedMask earlier{workspace_.coding.newly_seen(), work_.coded_mask_checksum};
  if (damage.ok() && kind == ProductKind::depth) {
    damage = load_maps(wiring_.store, work_.subject.depth, work_.subject.mask, loaded().maps, earlier);
  }
  if (damage.ok() && kind == ProductKind::image)
    damage = load_mask(wiring_.store, work_.subject.mask, loaded().maps, earlier);
  if (damage.ok() || (is_transient(damage) && !work_.patience.abandoned(keyframe_id))) return damage;
  DepthRecord none;
  none.id = keyframe_id;
  none.strip_id = work_.subject.keyframe.strip_id;
  none.verdict = DepthVerdict::too_few_valid;
  none.width = work_.subject.frame.width;
  none.height = work_.subject.frame.height;
  work_.subject.depth = none;
  ILP_TRY(loaded().maps.mask.resize(none.width, none.height));
  const std::size_t area = loaded().maps.mask.view().area();
  std::fill_n(loaded().maps.mask.view().data, area, std::uint8_t{255});
  work_.subject.mask = {};
  work_.subject.mask.id = keyframe_id;
  work_.subject.mask.newly_seen = static_cast<std::uint32_t>(area);
  return {};
}

/// `damage`: the maps could not be read.
Status Compressor::load(std::int64_t keyframe_id, ProductKind kind, Status& damage) {
  ILP_TRY(get(wiring_.store, keyframe_id, work_.subject.keyframe));
  ILP_TRY(get(wiring_.store, work_.subject.keyframe.frame_id, work_.subject.frame));
  ILP_TAKE(work_.interval_s, measure_interval(1));
  ILP_TAKE(work_.mean_interval_s, measure_interval(mean_keyframes));
  ILP_TAKE(const bool posed, find(wiring_.store, keyframe_id, work_.subject.pose));
  if (!posed) {
    work_.subject.pose = {};
    work_.subject.pose.id = keyframe_id;
    work_.subject.pose.strip_id = work_.subject.keyframe.strip_id;
    work_.subject.pose.state = PoseState::failed;
  }
  CameraRecord camera;
  ILP_TRY(get_camera(wiring_.store, camera_id, camera));
  work_.subject.camera = camera_model(camera);
  ILP_TRY(load_depth(keyframe_id, kind, damage));
  // A depth map is coded without the image.
  return kind == ProductKind::depth ? Status{} : load_keyframe_image(wiring_.store, keyframe_id, loaded().image);
}

/// Mean interval of the last `keyframes` keyframes, 0 if their first one is not on record. From records alone: a power
/// cut does not change what a keyframe is granted.
Result<double> Compressor::measure_interval(std::int64_t keyframes) {
  KeyframeRecord before;
  ILP_TAKE(const bool found, find(wiring_.store, work_.subject.keyframe.id - keyframes, before));
  if (!found) return 0.0;
  return 1e-9 * static_cast<double>(work_.subject.keyframe.time_ns - before.time_ns) / static_cast<double>(keyframes);
}

Status Compressor::write_metadata(const ProductRecord& product, ProductBox& box) {
  std::size_t sigma_bytes = 0;
  if (product.kind == ProductKind::depth) {
    ILP_TRY(encode_sigma_map(loaded().maps.sigma.view(), loaded().maps.mask.view(), loaded().sigma_map, sigma_bytes));
  }
  return write_product_metadata(product, work_.subject, wiring_.mission, {loaded().sigma_map.data(), sigma_bytes},
                                box.bytes, box.size);
}

void Compressor::set_params(const BitPlan& plan) {
  workspace_.coding.region = wiring_.mission.region_coding;
  workspace_.coding.params = {};
  Jpeg2000Params& params = workspace_.coding.params;
  params.max_bytes = plan.grant_bytes;
  params.layers = plan.layers;
  params.region_resolutions = wiring_.mission.region_resolutions;
  if (work_.order.product.kind == ProductKind::depth) {
    params.region = RegionCoding::drop_background;
    params.region_resolutions = 0;
    params.layer_ratio = depth_layer_ratio;
  } else if (plan.scheme == ProductScheme::thumbnail) {
    params.region = RegionCoding::none;
    workspace_.coding.region = false;
  } else {
    params.region = plan.region_only ? RegionCoding::drop_background : RegionCoding::shift;
    params.lossless = plan.scheme == ProductScheme::lossless_region;
  }
}

/// Hands the worker all that it needs.
Status Compressor::order(ProductKind kind) {
  const BitPlan plan = plan_bits(
      wiring_.mission, kind,
      {work_.subject.richness.richness, work_.subject.mask.newly_seen, loaded().maps.mask.view().area(),
       link_budget_bytes(wiring_.mission, work_.interval_s), link_budget_bytes(wiring_.mission, work_.mean_interval_s),
       state_.ranks.rank(work_.subject.richness.richness)});
  ProductRecord& product = work_.order.product;
  product.id = product_id(work_.subject.keyframe.id, kind);
  product.keyframe_id = work_.subject.keyframe.id;
  product.strip_id = work_.subject.keyframe.strip_id;
  product.kind = kind;
  product.scheme = plan.scheme;
  product.priority = plan.priority;
  product.grant_bytes = plan.grant_bytes;
  set_params(plan);
  ILP_TRY(write_metadata(product, workspace_.coding.box));
  if (workspace_.coding.params.lossless) {
    ProductRecord lossy = product;
    lossy.scheme = ProductScheme::lossy_region;
    ILP_TRY(write_metadata(lossy, workspace_.coding.box_if_lossy));
  }
  workspace_.coding.product = product;
  workspace_.coding.depth_error_px = wiring_.mission.depth_error_px;
  workspace_.coding.px_per_code = work_.subject.depth.step * work_.subject.depth.disparity_per_inverse_depth_px;
  const MaskView mask = loaded().maps.mask.view();
  workspace_.coding.width = mask.width;
  workspace_.coding.height = mask.height;
  std::copy_n(mask.data, mask.area(), workspace_.coding.mask.begin());
  work_.coded_mask_checksum =
      work_.subject.mask.code.bytes == 0 ? 0 : checksum_of_mask(work_.subject.mask, loaded().maps);
  if (kind == ProductKind::depth) {
    std::copy_n(loaded().maps.codes.view().data, mask.area(), workspace_.coding.codes().data);
  } else {
    const GrayView image = loaded().image.view();
    if (image.width != mask.width || image.height != mask.height) {
      return out_of_range(Argument::mask_size, mask.width);
    }
    std::copy_n(image.data, image.area(), workspace_.coding.image().data);
  }
  ILP_TRY(wiring_.worker->submit({code_product, &workspace_.coding}));
  work_.handed_over = work_.wanted = true;
  return {};
}

Status Compressor::write(const ProductRecord& product, const Cursor& cursor, State& after) {
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(wiring_.store, product));
  if (product.data.bytes != 0) {
    ILP_TRY(
        write_blob<ProductRecord>(wiring_.store, "data", product.id, 0, workspace_.coding.file().first(product.bytes)));
  }
  return transaction.commit(cursor, after, cursor_, state_);
}

/// The product is on record, as abandoned where there is none.
StepResult Compressor::finish(const Status& status, ProductRecord product) {
  const std::int64_t keyframe_id = work_.subject.richness.id;
  if (!status.ok() || work_.subject.mask.newly_seen == 0) {
    product.id = product_id(keyframe_id, work_.order.image ? ProductKind::image : ProductKind::depth);
    product.keyframe_id = keyframe_id;
    product.strip_id = work_.subject.richness.strip_id;
    product.kind = work_.order.image ? ProductKind::image : ProductKind::depth;
    product.state = ProductState::dropped;
    product.bytes = 0;
    product.data.bytes = 0;
  }
  State learned = state_;
  if (work_.order.image && !work_.order.unrated) learned.ranks.add(work_.subject.richness.richness);
  const Status written = write(product, work_.order.after, learned);
  if (!written.ok()) return Patience::not_written(written);
  return {work_.patience.abandoned(keyframe_id) ? Status{} : status, true};
}

StepResult Compressor::pick() {
  const Status found = next(wiring_.store, cursor_.first, work_.subject.richness);
  if (found.is(StatusCode::not_found)) return {};
  work_.order = {};
  work_.order.unrated = found.is(StatusCode::record_damaged);
  if (!found.ok() && !work_.order.unrated) return {found, false};
  if (work_.order.unrated) {
    work_.subject.richness = {};
    work_.subject.richness.id = found.a;
  }
  const std::int64_t keyframe_id = work_.subject.richness.id;

  // cursor.second is the keyframe whose depth is complete.
  work_.order.image = cursor_.second == keyframe_id;
  const ProductKind kind = work_.order.image ? ProductKind::image : ProductKind::depth;
  work_.order.after = work_.order.image ? Cursor{keyframe_id, keyframe_id} : Cursor{cursor_.first, keyframe_id};
  Status damage;
  Status status = load(keyframe_id, kind, damage);
  if (is_transient(status) && !work_.patience.abandoned(keyframe_id)) return work_.patience.failed(keyframe_id, status);
  const bool no_depth = work_.subject.depth.verdict != DepthVerdict::ok || work_.subject.mask.newly_seen == 0;
  if (status.ok() && damage.ok() && !work_.order.image && no_depth) {
    cursor_.second = keyframe_id;
    return {work_.order.unrated ? found : Status{}, true};
  }
  if (status.ok() && !work_.order.image) status = damage;
  if (!status.ok() || work_.subject.mask.newly_seen == 0) return finish(status, work_.order.product);
  work_.loaded = true;
  return {{}, true, Then::keep};
}

StepResult Compressor::order_loaded() {
  work_.loaded = false;
  const Status status = order(work_.order.image ? ProductKind::image : ProductKind::depth);
  StepResult result;
  if (status.ok() && ask_worker(result)) return result;
  return finish(status.ok() ? StatusCode::not_ready : status, work_.order.product);
}

/// Returns false if the worker has no product: one can be ordered.
bool Compressor::ask_worker(StepResult& result) {
  const WorkerProgress progress = wiring_.worker->ask();
  if (progress == WorkerProgress::working) {
    result = {{}, true, Then::wait};
    return true;
  }
  if (progress == WorkerProgress::stuck) {
    work_.stuck = true;
    const Status status{StatusCode::worker_stuck, work_.order.product.id, worker_limit_ns / ns_per_s};
    result = work_.wanted ? finish(status, work_.order.product) : StepResult{status, false};
    return true;
  }
  work_.handed_over = false;
  if (progress != WorkerProgress::done || !work_.wanted) return false;
  result = finish(workspace_.coding.status, workspace_.coding.product);
  return true;
}

StepResult Compressor::step() {
  // Without a worker there is nothing to do until the new start.
  const bool rests = wiring_.mission.safe_mode || work_.stuck;
  if (rests) work_.loaded = false;
  if (rests) return {};
  if (work_.loaded) return order_loaded();
  StepResult result;
  return work_.handed_over && ask_worker(result) ? result : pick();
}

}  // namespace ilp
