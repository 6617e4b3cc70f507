#include "fsw/products/compressor.hpp"

#include <algorithm>

#include "fsw/base/argument.hpp"
#include "fsw/shared/calibration_wait.hpp"
#include "fsw/shared/camera_on_record.hpp"
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
    : store_(store), mission_(mission), scratch_(scratch), worker_(worker != nullptr ? worker : &inline_worker_) {}

Status Compressor::restore() {
  // Whatever the flags were, the worker says whether it still has the memory of the job.
  handed_over_ = true;
  wanted_ = stuck_ = loaded_ = false;
  coded_mask_checksum_ = 0;
  const Status status = restore_checkpoint(store_, checkpoint, cursor_, state_);
  if (!restored(status)) return status;
  // A product on record was made. A product that the ground holds has left the store, and its keyframe with it.
  ProductRecord newest;
  const Status found = last(store_, newest);
  if (found.ok() && newest.keyframe_id > cursor_.first) {
    const bool image = newest.kind == ProductKind::image;
    if (newest.keyframe_id > cursor_.second) cursor_.second = newest.keyframe_id;
    cursor_.first = std::max(cursor_.first, image ? newest.keyframe_id : newest.keyframe_id - 1);
  }
  if (is_transient(found)) return found;
  return status;
}

/// Loads what the product needs of the maps. If it cannot be read, all of the image counts as new.
Status Compressor::load_depth(std::int64_t keyframe_id, ProductKind kind, Status& damage) {
  damage = get(store_, keyframe_id, subject_.depth);
  if (damage.ok()) damage = get(store_, keyframe_id, subject_.mask);
  // A keyframe's second product has the mask of its first one.
  const DecodedMask earlier{coding_.newly_seen(), coded_mask_checksum_};
  if (damage.ok() && kind == ProductKind::depth) {
    damage = load_maps(store_, subject_.depth, subject_.mask, work().maps, earlier);
  }
  if (damage.ok() && kind == ProductKind::image) damage = load_mask(store_, subject_.mask, work().maps, earlier);
  if (damage.ok() || (is_transient(damage) && !patience_.given_up(keyframe_id))) return damage;
  DepthRecord none;
  none.id = keyframe_id;
  none.strip_id = subject_.keyframe.strip_id;
  none.verdict = DepthVerdict::too_few_valid;
  none.width = subject_.frame.width;
  none.height = subject_.frame.height;
  subject_.depth = none;
  ILP_TRY(work().maps.mask.resize(none.width, none.height));
  const std::size_t area = work().maps.mask.view().area();
  std::fill_n(work().maps.mask.view().data, area, std::uint8_t{255});
  subject_.mask = {};
  subject_.mask.id = keyframe_id;
  subject_.mask.newly_seen = static_cast<std::uint32_t>(area);
  return {};
}

/// `damage`: the maps could not be read.
Status Compressor::load(std::int64_t keyframe_id, ProductKind kind, Status& damage) {
  ILP_TRY(get(store_, keyframe_id, subject_.keyframe));
  ILP_TRY(get(store_, subject_.keyframe.frame_id, subject_.frame));
  ILP_TRY(measure_interval(1, interval_s_));
  ILP_TRY(measure_interval(mean_keyframes, mean_interval_s_));
  const Status posed = get(store_, keyframe_id, subject_.pose);
  if (is_transient(posed)) return posed;
  if (!posed.ok()) {
    subject_.pose = {};
    subject_.pose.id = keyframe_id;
    subject_.pose.strip_id = subject_.keyframe.strip_id;
    subject_.pose.state = PoseState::failed;
  }
  CameraRecord camera;
  ILP_TRY(get_camera(store_, camera_id_of(subject_.pose), camera));
  subject_.camera = camera_model(camera);
  ILP_TRY(load_depth(keyframe_id, kind, damage));
  // A depth map is coded without the image.
  return kind == ProductKind::depth ? Status{} : load_frame_image(store_, subject_.keyframe.frame_id, work().image);
}

/// Mean interval of the last `keyframes` keyframes, 0 if their first one is not on record. From records alone: a power
/// cut does not change what a keyframe is granted.
Status Compressor::measure_interval(std::int64_t keyframes, double& interval_s) {
  interval_s = 0;
  KeyframeRecord before;
  const Status found = get(store_, subject_.keyframe.id - keyframes, before);
  if (is_gone(found)) return {};
  ILP_TRY(found);
  interval_s = 1e-9 * static_cast<double>(subject_.keyframe.time_ns - before.time_ns) / static_cast<double>(keyframes);
  return {};
}

Status Compressor::write_metadata(const ProductRecord& product, ProductBox& box) {
  std::size_t sigma_bytes = 0;
  if (product.kind == ProductKind::depth) {
    ILP_TRY(encode_sigma_map(work().maps.sigma.view(), work().maps.mask.view(), work().sigma_map, sigma_bytes));
  }
  return write_product_metadata(product, subject_, mission_, {work().sigma_map.data(), sigma_bytes}, box.bytes,
                                box.size);
}

void Compressor::set_params(const BitPlan& plan) {
  coding_.region = mission_.region_coding;
  coding_.params = {};
  Jpeg2000Params& params = coding_.params;
  params.max_bytes = plan.grant_bytes;
  params.layers = plan.layers;
  params.region_resolutions = mission_.region_resolutions;
  if (order_.product.kind == ProductKind::depth) {
    params.region = RegionCoding::drop_background;
    params.region_resolutions = 0;
    params.layer_ratio = depth_layer_ratio;
  } else if (plan.scheme == ProductScheme::thumbnail) {
    params.region = RegionCoding::none;
    coding_.region = false;
  } else {
    params.region = plan.region_only ? RegionCoding::drop_background : RegionCoding::shift;
    params.lossless = plan.scheme == ProductScheme::lossless_region;
  }
}

/// Hands the worker all that it needs.
Status Compressor::order(ProductKind kind) {
  const BitPlan plan =
      plan_bits(mission_, kind,
                {subject_.richness.richness, subject_.mask.newly_seen, work().maps.mask.view().area(),
                 link_budget_bytes(mission_, interval_s_), link_budget_bytes(mission_, mean_interval_s_),
                 state_.ranks.rank(subject_.richness.richness)});
  ProductRecord& product = order_.product;
  product.id = product_id(subject_.keyframe.id, kind);
  product.keyframe_id = subject_.keyframe.id;
  product.strip_id = subject_.keyframe.strip_id;
  product.kind = kind;
  product.scheme = plan.scheme;
  product.priority = plan.priority;
  product.grant_bytes = plan.grant_bytes;
  set_params(plan);
  ILP_TRY(write_metadata(product, coding_.box));
  if (coding_.params.lossless) {
    ProductRecord lossy = product;
    lossy.scheme = ProductScheme::lossy_region;
    ILP_TRY(write_metadata(lossy, coding_.box_if_lossy));
  }
  coding_.product = product;
  coding_.depth_error_px = mission_.depth_error_px;
  coding_.px_per_code = subject_.depth.step * subject_.depth.disparity_per_inverse_depth_px;
  const MaskView mask = work().maps.mask.view();
  coding_.width = mask.width;
  coding_.height = mask.height;
  std::copy_n(mask.data, mask.area(), coding_.mask.begin());
  coded_mask_checksum_ = subject_.mask.code.bytes == 0 ? 0 : checksum_of_mask(subject_.mask, work().maps);
  if (kind == ProductKind::depth) {
    std::copy_n(work().maps.codes.view().data, mask.area(), coding_.codes().data);
  } else {
    const GrayView image = work().image.view();
    if (image.width != mask.width || image.height != mask.height) {
      return out_of_range(Argument::mask_size, mask.width);
    }
    std::copy_n(image.data, image.area(), coding_.image().data);
  }
  ILP_TRY(worker_->submit({code_product, &coding_}));
  handed_over_ = wanted_ = true;
  return {};
}

Status Compressor::write(const ProductRecord& product, const Cursor& cursor, const State& after) {
  StepTransaction transaction(store_, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store_, product));
  if (product.data.bytes != 0) {
    ILP_TRY(write_blob<ProductRecord>(store_, "data", product.id, 0, coding_.file().first(product.bytes)));
  }
  return transaction.commit(cursor, after, cursor_, state_);
}

/// The product is on record, as abandoned where there is none.
StepResult Compressor::finish(const Status& status, ProductRecord product) {
  const std::int64_t keyframe_id = subject_.richness.id;
  if (!status.ok() || subject_.mask.newly_seen == 0) {
    product.id = product_id(keyframe_id, order_.image ? ProductKind::image : ProductKind::depth);
    product.keyframe_id = keyframe_id;
    product.strip_id = subject_.richness.strip_id;
    product.kind = order_.image ? ProductKind::image : ProductKind::depth;
    product.state = ProductState::dropped;
    product.bytes = 0;
    product.data.bytes = 0;
  }
  State learned = state_;
  if (order_.image && !order_.unrated) learned.ranks.add(subject_.richness.richness);
  const Status written = write(product, order_.after, learned);
  if (!written.ok()) return Patience::not_written(written);
  return {patience_.given_up(keyframe_id) ? Status{} : status, true};
}

StepResult Compressor::pick() {
  const Status found = next(store_, cursor_.first, subject_.richness);
  if (found.is(StatusCode::not_found)) return {};
  order_ = {};
  order_.unrated = found.is(StatusCode::record_damaged);
  if (!found.ok() && !order_.unrated) return {found, false};
  if (order_.unrated) {
    subject_.richness = {};
    subject_.richness.id = found.a;
  }
  const std::int64_t keyframe_id = subject_.richness.id;

  // cursor.second is the keyframe whose depth is complete.
  order_.image = cursor_.second == keyframe_id;
  const ProductKind kind = order_.image ? ProductKind::image : ProductKind::depth;
  order_.after = order_.image ? Cursor{keyframe_id, keyframe_id} : Cursor{cursor_.first, keyframe_id};
  Status damage;
  Status status = load(keyframe_id, kind, damage);
  if (is_transient(status) && !patience_.given_up(keyframe_id)) return patience_.failed(keyframe_id, status);
  const bool no_depth = subject_.depth.verdict != DepthVerdict::ok || subject_.mask.newly_seen == 0;
  if (status.ok() && damage.ok() && !order_.image && no_depth) {
    cursor_.second = keyframe_id;
    return {order_.unrated ? found : Status{}, true};
  }
  if (status.ok() && !order_.image) status = damage;
  if (!status.ok() || subject_.mask.newly_seen == 0) return finish(status, order_.product);
  loaded_ = true;
  return {{}, true, Then::keep};
}

StepResult Compressor::order_loaded() {
  loaded_ = false;
  const Status status = order(order_.image ? ProductKind::image : ProductKind::depth);
  StepResult result;
  if (status.ok() && ask_worker(result)) return result;
  return finish(status.ok() ? StatusCode::not_ready : status, order_.product);
}

/// Returns false if the worker has no product: one can be ordered.
bool Compressor::ask_worker(StepResult& result) {
  const WorkerProgress progress = worker_->ask();
  if (progress == WorkerProgress::working) {
    result = {{}, true, Then::wait};
    return true;
  }
  if (progress == WorkerProgress::stuck) {
    stuck_ = true;
    const Status status{StatusCode::worker_stuck, order_.product.id, worker_limit_ns / ns_per_s};
    result = wanted_ ? finish(status, order_.product) : StepResult{status, false};
    return true;
  }
  handed_over_ = false;
  if (progress != WorkerProgress::done || !wanted_) return false;
  result = finish(coding_.status, coding_.product);
  return true;
}

StepResult Compressor::step() {
  // Without a worker there is nothing to do until the new start.
  const bool rests = mission_.safe_mode || stuck_;
  if (rests) loaded_ = false;
  if (rests) return {};
  if (loaded_) return order_loaded();
  StepResult result;
  return handed_over_ && ask_worker(result) ? result : pick();
}

}  // namespace ilp
