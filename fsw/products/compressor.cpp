#include "fsw/products/compressor.hpp"

#include <algorithm>

#include "fsw/base/crc.hpp"
#include "fsw/shared/calibration_wait.hpp"
#include "fsw/shared/camera_on_record.hpp"
#include "fsw/shared/frame_access.hpp"
#include "fsw/shared/product_layers.hpp"
#include "fsw/vision/codec/layer_errors.hpp"
#include "fsw/vision/terrain/depth_coding.hpp"

namespace ilp {
namespace {

// Finer than an image's, so that the requested error is met with few extra bytes.
constexpr double depth_layer_ratio = 0.7;

// The intervals of single keyframes vary too much to say how narrow the link is.
constexpr std::int64_t mean_keyframes = 10;

// In steps of the codes: half a step for rounding, the rest for the ground's single precision.
constexpr double rounding_steps = 0.51;

}  // namespace

constexpr CheckpointForm Compressor::checkpoint = checkpoint_form<State>(component_id);

Compressor::Compressor(Tables store, const MissionParameters& mission, Scratch scratch)
    : store_(store), mission_(mission), scratch_(scratch) {}

Status Compressor::restore() {
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
  if (!found.ok() && is_transient(found)) return found;
  return status;
}

/// Loads the maps. If they cannot be read, all of the image counts as new.
Status Compressor::load_depth(std::int64_t keyframe_id, Status& damage) {
  damage = get(store_, keyframe_id, subject_.depth);
  if (damage.ok()) damage = load_maps(store_, subject_.depth, work().maps);
  if (damage.ok() || (is_transient(damage) && !patience_.given_up(keyframe_id))) return damage;
  DepthRecord none;
  none.id = keyframe_id;
  none.strip_id = subject_.keyframe.strip_id;
  none.verdict = DepthVerdict::too_few_valid;
  none.width = subject_.frame.width;
  none.height = subject_.frame.height;
  subject_.depth = none;
  ILP_TRY(work().maps.codes.resize(none.width, none.height));
  ILP_TRY(work().maps.sigma.resize(none.width, none.height));
  ILP_TRY(work().maps.mask.resize(none.width, none.height));
  const std::size_t area = work().maps.mask.view().area();
  std::fill_n(work().maps.codes.view().data, area, std::uint16_t{0});
  std::fill_n(work().maps.sigma.view().data, area, std::uint8_t{0});
  std::fill_n(work().maps.mask.view().data, area, std::uint8_t{255});
  subject_.depth.newly_seen = static_cast<std::uint32_t>(area);
  return {};
}

/// `damage`: the maps could not be read.
Status Compressor::load(std::int64_t keyframe_id, ProductKind kind, Status& damage) {
  ILP_TRY(get(store_, keyframe_id, subject_.keyframe));
  ILP_TRY(get(store_, subject_.keyframe.frame_id, subject_.frame));
  ILP_TRY(measure_interval(1, interval_s_));
  ILP_TRY(measure_interval(mean_keyframes, mean_interval_s_));
  const Status posed = get(store_, keyframe_id, subject_.pose);
  if (!posed.ok() && is_transient(posed)) return posed;
  if (!posed.ok()) {
    subject_.pose = {};
    subject_.pose.id = keyframe_id;
    subject_.pose.strip_id = subject_.keyframe.strip_id;
    subject_.pose.state = PoseState::failed;
  }
  CameraRecord camera;
  ILP_TRY(get_camera(store_, camera_id_of(subject_.pose), camera));
  subject_.camera = camera_model(camera);
  ILP_TRY(load_depth(keyframe_id, damage));
  const Status image = load_frame_image(store_, subject_.keyframe.frame_id, work().image);
  // A depth map is coded without the image.
  return kind == ProductKind::depth && !is_transient(image) ? Status{} : image;
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

Status Compressor::write_metadata(const ProductRecord& product) {
  std::size_t sigma_bytes = 0;
  if (product.kind == ProductKind::depth) {
    ILP_TRY(encode_sigma_map(work().maps.sigma.view(), work().maps.mask.view(), sigma_map_, sigma_bytes));
  }
  return write_product_metadata(product, subject_, mission_, {sigma_map_.data(), sigma_bytes}, metadata_,
                                metadata_bytes_);
}

Status Compressor::measure_layers(const Jpeg2000Product& coded, ProductRecord& product) {
  product.bytes = static_cast<std::uint32_t>(coded.bytes);
  product.layers = static_cast<std::uint8_t>(coded.layers);
  const std::span<const std::uint8_t> file{work().file.data(), coded.bytes};
  const bool whole = product.scheme == ProductScheme::thumbnail;
  LayerErrors errors;
  if (product.kind == ProductKind::depth) {
    ILP_TRY(measure_layer_errors(file, work().maps.codes.view(), work().maps.mask.view(), work().jpeg2000, errors));
  } else {
    ILP_TRY(measure_layer_errors(file, work().image.view(), whole ? MaskView{} : work().maps.mask.view(),
                                 work().jpeg2000, errors));
  }
  const double px_per_code = subject_.depth.step * subject_.depth.disparity_per_inverse_depth_px;
  for (std::size_t i = 0; i < product.layers; ++i) {
    product.layer_bytes[i] = static_cast<std::uint32_t>(coded.layer_bytes[i]);
    const double quality = product.kind == ProductKind::depth ? (errors.largest[i] + rounding_steps) * px_per_code
                                                              : psnr_of(errors.mean_square[i]);
    product.layer_quality[i] = static_cast<float>(quality);
  }
  return {};
}

/// Layers with digits below the requested error are not worth their bytes.
Status Compressor::leave_off_layers(ProductRecord& product) {
  if (product.kind != ProductKind::depth || !(mission_.depth_error_px > 0)) return {};
  std::uint8_t needed = 0;
  bool kept = false;
  while (!kept && needed < product.layers) {
    kept = static_cast<double>(product.layer_quality[needed]) <= mission_.depth_error_px;
    ++needed;
  }
  if (needed == product.layers) return {};
  std::size_t bytes = 0;
  ILP_TRY(truncate_to_layers(std::span(work().file).first(product.bytes), needed, bytes));
  keep_layers(needed, bytes, product);
  return {};
}

Status Compressor::encode(ProductKind kind, ProductRecord& product) {
  const BitPlan plan =
      plan_bits(mission_, kind,
                {subject_.richness.richness, subject_.depth.newly_seen, work().image.view().area(),
                 link_budget_bytes(mission_, interval_s_), link_budget_bytes(mission_, mean_interval_s_),
                 state_.ranks.rank(subject_.richness.richness)});
  product.id = product_id(subject_.keyframe.id, kind);
  product.keyframe_id = subject_.keyframe.id;
  product.strip_id = subject_.keyframe.strip_id;
  product.kind = kind;
  product.scheme = plan.scheme;
  product.priority = plan.priority;
  product.grant_bytes = plan.grant_bytes;
  ILP_TRY(write_metadata(product));
  const std::span<const std::uint8_t> metadata{metadata_.data(), metadata_bytes_};

  Jpeg2000Params params;
  params.max_bytes = plan.grant_bytes;
  params.layers = plan.layers;
  params.region_resolutions = mission_.region_resolutions;
  Jpeg2000Product coded;
  const MaskView region = mission_.region_coding ? MaskView(work().maps.mask.view()) : MaskView{};
  if (kind == ProductKind::depth) {
    params.region = RegionCoding::drop_background;
    params.region_resolutions = 0;
    params.layer_ratio = depth_layer_ratio;
    ILP_TRY(encode_jpeg2000(work().maps.codes.view(), depth_code_bits, region, params, metadata, work().jpeg2000,
                            work().file, coded));
  } else if (plan.scheme == ProductScheme::thumbnail) {
    params.region = RegionCoding::none;
    ILP_TRY(encode_jpeg2000(work().image.view(), MaskView{}, params, metadata, work().jpeg2000, work().file, coded));
  } else {
    params.region = plan.region_only ? RegionCoding::drop_background : RegionCoding::shift;
    params.lossless = plan.scheme == ProductScheme::lossless_region;
    Status status = encode_jpeg2000(work().image.view(), region, params, metadata, work().jpeg2000, work().file, coded);
    if (params.lossless && status.is(StatusCode::grant_too_small)) {
      product.scheme = ProductScheme::lossy_region;
      params.lossless = false;
      ILP_TRY(write_metadata(product));
      status = encode_jpeg2000(work().image.view(), region, params, {metadata_.data(), metadata_bytes_},
                               work().jpeg2000, work().file, coded);
    }
    ILP_TRY(status);
  }
  ILP_ASSERT(coded.bytes <= plan.grant_bytes, coded.bytes);
  ILP_TRY(measure_layers(coded, product));
  ILP_TRY(leave_off_layers(product));
  const std::span<std::uint8_t> file{work().file.data(), product.bytes};
  ILP_TRY(fill_in_layer_quality(product, file));
  product.crc32 = crc32(file);
  product.data.bytes = product.bytes;
  return {};
}

Status Compressor::write(const ProductRecord& product, const Cursor& cursor, const State& after) {
  StepTransaction transaction(store_, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store_, product));
  if (product.data.bytes != 0) {
    ILP_TRY(write_blob<ProductRecord>(store_, "data", product.id, 0, {work().file.data(), product.bytes}));
  }
  return transaction.commit(cursor, after, cursor_, state_);
}

StepResult Compressor::step() {
  if (mission_.safe_mode) return {};
  const Status found = next(store_, cursor_.first, subject_.richness);
  if (found.is(StatusCode::not_found)) return {};
  const bool unrated = found.is(StatusCode::record_damaged);
  if (!found.ok() && !unrated) return {found, false};
  if (unrated) {
    subject_.richness = {};
    subject_.richness.id = found.a;
  }
  const std::int64_t keyframe_id = subject_.richness.id;

  // cursor.second is the keyframe whose depth is complete.
  const bool depth_done = cursor_.second == keyframe_id;
  const ProductKind kind = depth_done ? ProductKind::image : ProductKind::depth;
  const Cursor after = depth_done ? Cursor{keyframe_id, keyframe_id} : Cursor{cursor_.first, keyframe_id};
  Status damage;
  Status status = load(keyframe_id, kind, damage);
  if (is_transient(status) && !patience_.given_up(keyframe_id)) return patience_.failed(keyframe_id, status);
  const bool no_depth = subject_.depth.verdict != DepthVerdict::ok || subject_.depth.newly_seen == 0;
  if (status.ok() && damage.ok() && !depth_done && no_depth) {
    cursor_.second = keyframe_id;
    return {unrated ? found : Status{}, true};
  }
  ProductRecord product;
  if (status.ok() && !depth_done) status = damage;
  const bool nothing_new = subject_.depth.newly_seen == 0;
  if (status.ok() && !nothing_new) status = encode(kind, product);
  if (!status.ok() || nothing_new) {
    // The keyframe is complete, with the product on record as abandoned.
    product.id = product_id(keyframe_id, kind);
    product.keyframe_id = keyframe_id;
    product.strip_id = subject_.richness.strip_id;
    product.kind = kind;
    product.state = ProductState::dropped;
    product.bytes = 0;
    product.data.bytes = 0;
  }
  State learned = state_;
  if (depth_done && !unrated) learned.ranks.add(subject_.richness.richness);
  const Status written = write(product, after, learned);
  if (!written.ok()) return Patience::not_written(written);
  return {patience_.given_up(keyframe_id) ? Status{} : status, true};
}

}  // namespace ilp
