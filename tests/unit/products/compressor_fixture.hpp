// A store with keyframes that wait for their products.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "fsw/base/crc.hpp"
#include "fsw/products/compressor.hpp"
#include "fsw/vision/codec/jpeg2000_decode.hpp"
#include "fsw/vision/terrain/depth_coding.hpp"
#include "fsw/vision/terrain/mask_coding.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/support/strip.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp::test {

class CompressorTest : public ComponentTest {
 protected:
  static constexpr std::int32_t width = 256, height = 192;
  static constexpr std::size_t pixels = std::size_t{width} * height;
  static constexpr double disparity_per_inverse_depth_px = 450;

  double hollow_px = 0;  ///< of the disc of new ground, the radius of what is not new

  /// One keyframe with everything that the compressor wants of it; a disc of the image is new.
  void write_keyframe(std::int64_t id, double richness, double share, TimeNs time = 1'000'000'000) {
    CameraRecord camera;
    camera.id = camera_id;
    camera.width = width;
    camera.height = height;
    camera.fx = camera.fy = 220;
    camera.cx = width / 2.0;
    camera.cy = height / 2.0;
    write(camera);
    FrameRecord frame{.id = 10 * id, .time_ns = time, .width = width, .height = height};
    frame.image.bytes = pixels;
    std::strcpy(frame.name, "0007.pgm");
    image = render_texture(width, height, {2, 0.1, 0, 0}, 1, 0, 1, 4);
    write(frame, "image", image.pixels);
    KeyframeRecord keyframe{.id = id, .frame_id = frame.id, .strip_id = 3, .time_ns = time};
    write(keyframe);
    PoseRecord pose{.id = id, .strip_id = 3, .state = PoseState::final};
    pose.q_cam_from_world[0] = 1;
    pose.centre[1] = 2.5;
    pose.sigma[2] = 0.125;
    // Variances of the attitude about y and of the centre along y, correlated by -0.8.
    pose.covariance[2] = 0.003 * 0.003;
    pose.covariance[14] = 0.125 * 0.125;
    pose.covariance[11] = -0.8 * 0.003 * 0.125;
    write(pose);
    write_depth(id, share);
    RichnessRecord index{.id = id, .strip_id = 3, .richness = richness, .relief = 0.25};
    write(index);
  }

  void write_depth(std::int64_t id, double share) {
    mask.assign(pixels, 0);
    inverse_depth.assign(pixels, 0.0F);
    std::vector<float> sigma(pixels, 0.0F);
    DepthRecord depth;
    MaskRecord new_ground;
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = 0; x < width; ++x) {
        const auto i = static_cast<std::size_t>(y * width + x);
        const double dx = x - 150, dy = y - 90;
        const double squared = dx * dx + dy * dy;
        const double outer = share * static_cast<double>(pixels) / 3.14159 + hollow_px * hollow_px;
        if (squared > outer || squared < hollow_px * hollow_px) continue;
        mask[i] = 255;
        ++new_ground.newly_seen;
        sigma[i] = 1;
        inverse_depth[i] = static_cast<float>(0.05 + 0.01 * std::sin(x * 0.05) * std::cos(y * 0.04) +
                                              0.0003 * std::sin(x * 0.9 + y * 0.7));
      }
    }
    DepthCoding coding;
    const ImageView<const float> rho(inverse_depth.data(), width, height), error(sigma.data(), width, height);
    const MaskView inside(mask.data(), width, height);
    ASSERT_TRUE(choose_depth_coding(rho, error, inside, disparity_per_inverse_depth_px, 1, 16, coding).ok());
    std::vector<std::uint16_t> codes(pixels);
    ASSERT_TRUE(encode_depth(rho, error, inside, coding, ImageView<std::uint16_t>(codes.data(), width, height)).ok());
    std::vector<std::uint8_t> coded(max_mask_bytes(pixels));
    std::size_t mask_bytes = 0;
    ASSERT_TRUE(encode_mask(inside, coded.data(), coded.size(), mask_bytes).ok());
    depth.id = id;
    depth.width = width;
    depth.height = height;
    depth.offset = coding.offset;
    depth.step = coding.step;
    depth.disparity_per_inverse_depth_px = disparity_per_inverse_depth_px;
    depth.values.bytes = 2 * pixels;
    depth.sigma.bytes = pixels;
    new_ground.id = id;
    new_ground.scope = MaskScope::flight;
    new_ground.width = width;
    new_ground.height = height;
    new_ground.code.bytes = static_cast<std::uint32_t>(mask_bytes);
    const std::vector<std::uint8_t> sigma_codes(pixels, 9);
    Transaction transaction(store);
    ASSERT_TRUE(transaction.begin().ok());
    ASSERT_TRUE(put(store, depth).ok());
    ASSERT_TRUE(put(store, new_ground).ok());
    const auto* values = reinterpret_cast<const std::uint8_t*>(codes.data());
    ASSERT_TRUE(write_blob<DepthRecord>(store, "values", id, 0, {values, 2 * pixels}).ok());
    ASSERT_TRUE(write_blob<DepthRecord>(store, "sigma", id, 0, sigma_codes).ok());
    ASSERT_TRUE(write_blob<MaskRecord>(store, "code", id, 0, {coded.data(), mask_bytes}).ok());
    ASSERT_TRUE(transaction.commit().ok());
  }

  void compress() {
    const auto compressor = std::make_unique<Compressor>(store, mission, step_memory<Compressor>());
    ASSERT_TRUE(compressor->restore().ok());
    for (const Status& fault : run(*compressor)) ADD_FAILURE() << status_name(fault.code) << " " << fault.a;
  }

  /// The product cut after `layers`, and what decoding it gives.
  std::vector<std::int32_t> decode(const ProductRecord& product, int layers) {
    file.resize(product.bytes);
    EXPECT_TRUE(read_blob<ProductRecord>(store, "data", product.id, 0, file).ok());
    EXPECT_EQ(crc32(file), product.crc32);
    std::size_t bytes = 0;
    EXPECT_TRUE(truncate_to_layers(file, layers, bytes).ok());
    EXPECT_EQ(bytes, product.layer_bytes[layers - 1]);
    file.resize(bytes);
    std::vector<std::int32_t> samples(pixels);
    EXPECT_TRUE(decode_jpeg2000(file, false, {samples.data(), width, height}).ok());
    return samples;
  }

  Image image;
  std::vector<std::uint8_t> mask;
  std::vector<float> inverse_depth;
  std::vector<std::uint8_t> file;
};

}  // namespace ilp::test
