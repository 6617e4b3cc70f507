#include "fsw/components/compressor.hpp"

#include "cfg/version.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/components/calibration_wait.hpp"
#include "fsw/components/frame_access.hpp"
#include "fsw/vision/codec/metadata.hpp"
#include "fsw/vision/terrain/depth_coding.hpp"

namespace ilp {
namespace {

constexpr std::uint32_t layout = 1;

const char* scheme_name(ProductScheme scheme) {
  switch (scheme) {
    case ProductScheme::lossless_region:
      return "lossless_region";
    case ProductScheme::thumbnail:
      return "thumbnail";
    default:
      return "lossy_region";
  }
}

}  // namespace

Compressor::Compressor(Store& store, const MissionParameters& mission) : store_(store), mission_(mission) {}

Status Compressor::restore() {
  cursor_ = {};
  const Status status = load_checkpoint(store_, ComponentId::compressor, cursor_, layout, std::span<std::uint8_t>{});
  return status.is(StatusCode::not_found) ? Status{} : status;
}

Status Compressor::load(std::int64_t keyframe_id) {
  ILP_TRY(get(store_, keyframe_id, subject_.depth));
  ILP_TRY(get(store_, keyframe_id, subject_.keyframe));
  ILP_TRY(get(store_, subject_.keyframe.frame_id, subject_.frame));
  ILP_TRY(get(store_, keyframe_id, subject_.pose));
  CameraRecord camera;
  ILP_TRY(get(store_, camera_id_of(subject_.pose), camera));
  camera_ = camera_model(camera);
  ILP_TRY(load_frame_image(store_, subject_.keyframe.frame_id, image_));
  return load_maps(store_, subject_.depth, maps_);
}

Status Compressor::write_metadata(const ProductRecord& product) {
  const PoseRecord& pose = subject_.pose;
  const DepthRecord& depth = subject_.depth;
  MetadataWriter writer(metadata_);
  writer.text("software", software_version);
  writer.integer("product", product.id);
  writer.integer("keyframe", product.keyframe_id);
  writer.integer("strip", product.strip_id);
  writer.text("kind", product.kind == ProductKind::image ? "image" : "depth");
  writer.text("frame_name", subject_.frame.name);
  writer.integer("time_ns", subject_.frame.time_ns);
  writer.integer("width", subject_.frame.width);
  writer.integer("height", subject_.frame.height);
  const bool calibrated = !waited_in_vain(pose);
  const double camera[] = {camera_.fx, camera_.fy, camera_.cx, camera_.cy,
                           camera_.k1, camera_.k2, camera_.p1, camera_.p2};
  // By the pose, not by the camera as it is: whether it has been calibrated since is a matter of timing.
  writer.reals(calibrated ? "camera" : "camera_nominal", camera);
  if (pose.state == PoseState::final) {
    writer.reals("q_cam_from_world", pose.q_cam_from_world);
    writer.reals("centre", pose.centre);
    writer.reals("sigma", pose.sigma);
  }
  writer.text("scheme", scheme_name(product.scheme));
  writer.integer("grant_bytes", product.grant_bytes);
  writer.real("richness", subject_.richness.richness);
  if (product.kind == ProductKind::depth) {
    writer.real("depth_offset", depth.offset);
    writer.real("depth_step", depth.step);
    writer.real("disparity_per_inverse_depth_px", depth.disparity_per_inverse_depth_px);
    writer.integer("partner", depth.partner_id);
    std::size_t size = 0;
    ILP_TRY(encode_sigma_map(maps_.sigma.view(), maps_.mask.view(), sigma_map_, size));
    writer.text("sigma_map", {sigma_map_.data(), size});
  }
  metadata_bytes_ = writer.bytes().size();
  return writer.status();
}

Status Compressor::encode(ProductKind kind, ProductRecord& product) {
  const BitPlan plan =
      plan_bits(mission_, kind, subject_.richness.richness, subject_.depth.newly_seen, image_.view().area());
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
  params.layers = static_cast<int>(mission_.quality_layers);
  params.region_resolutions = static_cast<int>(mission_.region_resolutions);
  Jpeg2000Product coded;
  if (kind == ProductKind::depth) {
    params.region = RegionCoding::drop_background;
    ILP_TRY(encode_jpeg2000(maps_.codes.view(), depth_code_bits, maps_.mask.view(), params, metadata, workspace_, file_,
                            coded));
  } else if (plan.scheme == ProductScheme::thumbnail) {
    params.region = RegionCoding::none;
    ILP_TRY(encode_jpeg2000(image_.view(), MaskView{}, params, metadata, workspace_, file_, coded));
  } else {
    params.region = RegionCoding::shift;
    ILP_TRY(encode_jpeg2000(image_.view(), maps_.mask.view(), params, metadata, workspace_, file_, coded));
  }
  ILP_ASSERT(coded.bytes <= plan.grant_bytes, coded.bytes);
  product.bytes = static_cast<std::uint32_t>(coded.bytes);
  product.layers = static_cast<std::uint8_t>(coded.layers);
  for (std::size_t i = 0; i < static_cast<std::size_t>(coded.layers); ++i) {
    product.layer_bytes[i] = static_cast<std::uint32_t>(coded.layer_bytes[i]);
  }
  product.crc32 = crc32({file_.data(), coded.bytes});
  product.data.bytes = product.bytes;
  return {};
}

Status Compressor::write(const ProductRecord& product, const Cursor& cursor) {
  Transaction transaction(store_);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store_, product));
  if (product.data.bytes != 0) {
    ILP_TRY(write_blob<ProductRecord>(store_, "data", product.id, 0, {file_.data(), product.bytes}));
  }
  ILP_TRY(save_checkpoint(store_, ComponentId::compressor, cursor, layout, std::span<const std::uint8_t>{}));
  ILP_TRY(transaction.commit());
  cursor_ = cursor;
  return {};
}

StepResult Compressor::step(TimeNs deadline) {
  static_cast<void>(deadline);
  const Status found = next(store_, cursor_.first, subject_.richness);
  if (found.is(StatusCode::not_found)) return {};
  if (!found.ok()) return {found, false};
  const std::int64_t keyframe_id = subject_.richness.id;

  // cursor.second: the keyframe whose depth has been dealt with already.
  const bool depth_done = cursor_.second == keyframe_id;
  const ProductKind kind = depth_done ? ProductKind::image : ProductKind::depth;
  const Cursor after = depth_done ? Cursor{keyframe_id, keyframe_id} : Cursor{cursor_.first, keyframe_id};
  Status status = load(keyframe_id);
  const bool no_depth = subject_.depth.verdict != DepthVerdict::ok || subject_.depth.newly_seen == 0;
  if (status.ok() && !depth_done && no_depth) {
    cursor_.second = keyframe_id;
    return {{}, true};
  }
  ProductRecord product;
  if (status.ok()) status = encode(kind, product);
  if (!status.ok()) {
    // The keyframe is done with all the same: on record as given up.
    product.id = product_id(keyframe_id, kind);
    product.keyframe_id = keyframe_id;
    product.strip_id = subject_.richness.strip_id;
    product.kind = kind;
    product.state = ProductState::dropped;
    product.bytes = 0;
    product.data.bytes = 0;
  }
  const Status written = write(product, after);
  if (!written.ok()) return {written, false};
  return {status, true};
}

}  // namespace ilp
