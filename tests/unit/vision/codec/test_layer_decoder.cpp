// Layers that are computed from the coefficients that were coded are those that OpenJPEG decodes.
#include <gtest/gtest.h>

#include <algorithm>

#include "fsw/base/rng.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/codec/layer_decoder.hpp"
#include "fsw/vision/codec/layer_errors.hpp"
#include "fsw/vision/codec/wavelet53.hpp"
#include "tests/unit/vision/codec/product_fixture.hpp"

namespace ilp {
namespace {

using namespace test;

std::int32_t between(Rng& rng, std::int32_t first, std::int32_t last) {
  return first + static_cast<std::int32_t>(rng.below(static_cast<std::uint32_t>(last - first + 1)));
}

/// Waves and noise, each more or less; some have plain parts, which take no passes at all.
Depth random_samples(Rng& rng, std::int32_t width, std::int32_t height, int bits) {
  Depth samples(width, height);
  const double full = std::ldexp(1.0, bits) - 1;
  const double wave = rng.uniform() * 0.5, noise = rng.uniform() < 0.3 ? 0.5 : rng.uniform() * 0.05;
  const double fx = 0.4 * rng.uniform(), fy = 0.4 * rng.uniform();
  const std::int32_t plain = rng.uniform() < 0.3 ? between(rng, 0, width) : width;
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      const double t = 0.5 + wave * std::sin(fx * x) * std::cos(fy * y) + noise * (rng.uniform() - 0.5);
      samples.at(x, y) = static_cast<std::uint16_t>(std::lround((x < plain ? std::clamp(t, 0.0, 1.0) : 0.5) * full));
    }
  }
  return samples;
}

Mask random_mask(Rng& rng, std::int32_t width, std::int32_t height) {
  Mask mask(width, height);
  const int kind = between(rng, 0, 3);
  const std::int32_t x0 = between(rng, 0, width - 1), y0 = between(rng, 0, height - 1);
  const std::int32_t x1 = between(rng, x0, width - 1), y1 = between(rng, y0, height - 1);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      const bool inside[] = {true, x >= x0 && x <= x1 && y >= y0 && y <= y1, x == x0 && y == y0, rng.below(50) == 0};
      mask.at(x, y) = inside[kind] ? 1 : 0;
    }
  }
  return mask;
}

class LayerDecoderTest : public Jpeg2000Test {
 protected:
  /// One product of random samples, or none where its grant is too small.
  bool random_product(std::uint64_t seed) {
    Rng rng(seed);
    const bool large = rng.below(4) == 0;
    width = between(rng, 1, large ? 400 : 150);
    height = between(rng, 1, large ? 300 : 150);
    bits = between(rng, 1, 3) == 1 ? between(rng, 1, 16) : 8 + 5 * between(rng, 0, 1);
    samples = random_samples(rng, width, height, bits);
    mask = random_mask(rng, width, height);
    Jpeg2000Params params;
    params.region = static_cast<RegionCoding>(between(rng, 0, 2));
    params.region_resolutions = between(rng, 0, 2);
    params.wavelet_levels = between(rng, 0, limits::max_wavelet_levels);
    params.layers = between(rng, 1, limits::max_quality_layers);
    params.layer_ratio = 0.4 + 0.5 * rng.uniform();
    params.lossless = rng.below(6) == 0;
    const double full = width * height * bits / 8.0;
    params.max_bytes =
        params.lossless ? file.size() : static_cast<std::size_t>(300 + full * rng.uniform() * rng.uniform());
    const Status status = encode(samples, bits, mask.view(), params);
    EXPECT_TRUE(status.ok() || status.is(StatusCode::grant_too_small) || status.is(StatusCode::coefficient_overflow))
        << status_name(status.code);
    return status.ok();
  }

  [[nodiscard]] Decoded decode_cut(int layers) const {
    std::vector<std::uint8_t> copy(bytes().begin(), bytes().end());
    std::size_t size = 0;
    EXPECT_TRUE(truncate_to_layers(copy, layers, size).ok());
    return decode(std::span(copy).first(size));
  }

  [[nodiscard]] ImageView<const std::int32_t> coefficients() const {
    return {workspace->samples.data(), width, height};
  }
  [[nodiscard]] std::span<const PassEnd> pass_ends() const {
    return place_of_pass_ends(*workspace).first(workspace->pass_ends);
  }
  [[nodiscard]] std::span<const std::uint8_t> codestream() const {
    Jpeg2000Info info;
    EXPECT_TRUE(read_jpeg2000_header(bytes(), info).ok());
    return info.codestream;
  }

  std::int32_t width = 0, height = 0;
  int bits = 8;
  Depth samples{0, 0};
  Mask mask{0, 0};
  LayerErrors errors;
};

TEST_F(LayerDecoderTest, EverySampleOfEveryLayerIsThatOfOpenJpeg) {
  int known = 0, not_known = 0, shifted = 0;
  for (std::uint64_t seed = 1; seed <= 250; ++seed) {
    SCOPED_TRACE(seed);
    if (!random_product(seed)) continue;
    if (product.shift > 0) ++shifted;
    Rng rng(seed);
    SampleWindow window;
    window.x0 = between(rng, 0, width - 1);
    window.y0 = between(rng, 0, height - 1);
    window.x1 = between(rng, window.x0 + 1, width);
    window.y1 = between(rng, window.y0 + 1, height);
    if (seed % 2 == 0) window = {0, 0, width, height};
    LayerDecoder decoder;
    const std::span<const std::uint8_t> coded = codestream();
    ASSERT_TRUE(decoder.prepare(coded, coefficients(), pass_ends(), window).ok());
    std::vector<std::uint64_t> memory(decoder.memory_bytes() / 8 + 1);
    const Status begun = decoder.begin({reinterpret_cast<std::uint8_t*>(memory.data()), memory.size() * 8});
    ASSERT_TRUE(begun.ok()) << status_name(begun.code) << " " << begun.a;
    ASSERT_EQ(decoder.layers(), product.layers);
    DoubtfulBlocks doubtful;
    std::vector<std::vector<std::int32_t>> blocks;
    std::vector<std::int32_t> scratch(block_scratch_bytes / 4);
    for (int layers = 1; layers <= product.layers; ++layers) {
      ++known;
      ImageView<const std::int32_t> computed = decoder.decode(layers, doubtful);
      if (computed.empty()) {
        ++not_known;
        for (DoubtfulBlock& block : doubtful.view()) {
          if (block.coefficients != nullptr) continue;
          std::vector<std::int32_t>& to = blocks.emplace_back(std::size_t{code_block_side} * code_block_side);
          const Status status = decode_block(coded, decoder.style(), block.part,
                                             {reinterpret_cast<std::uint8_t*>(scratch.data()), block_scratch_bytes},
                                             {to.data(), block.part.width, block.part.height});
          ASSERT_TRUE(status.ok()) << status_name(status.code) << " " << status.b;
          block.coefficients = to.data();
        }
        computed = decoder.decode(layers, doubtful);
        if (doubtful.count == doubtful.blocks.size()) break;
      }
      ASSERT_EQ(computed.width, window.x1 - window.x0);
      ASSERT_EQ(computed.height, window.y1 - window.y0);
      const Decoded decoded = decode_cut(layers);
      const std::int32_t half = 1 << (bits - 1), most = (1 << bits) - 1;
      for (std::int32_t y = window.y0; y < window.y1; ++y) {
        for (std::int32_t x = window.x0; x < window.x1; ++x) {
          const std::int32_t sample = std::clamp(computed.at(x - window.x0, y - window.y0) + half, 0, most);
          ASSERT_EQ(sample, decoded.view().at(x, y)) << "layer " << layers << ", " << x << ", " << y;
        }
      }
    }
  }
  std::printf("%d layers, %d of them with code-blocks that were decoded; %d products with a shifted region\n", known,
              not_known, shifted);
  EXPECT_GT(known, 400);
  EXPECT_GT(not_known, 0) << "no pass lacks a byte: the check is not tested";
  EXPECT_LT(not_known, known / 3) << "or there is nothing gained";
  EXPECT_GT(shifted, 20);
}

TEST_F(LayerDecoderTest, BothVectorWidthsGiveTheSameErrors) {
  for (std::uint64_t seed = 500; seed < 530; ++seed) {
    std::array<LayerErrors, 2> of_width;
    for (const bool wide : {false, true}) {
      if (wide && widest_vectors() != VectorWidth::bytes32) continue;
      use_vectors(wide ? VectorWidth::bytes32 : VectorWidth::bytes16);
      if (!random_product(seed)) continue;
      if (bits > 13) continue;
      ASSERT_TRUE(measure_layer_errors(bytes(), samples.view(), mask.view(), *workspace, of_width[wide ? 1 : 0]).ok());
    }
    use_vectors(widest_vectors());
    if (widest_vectors() != VectorWidth::bytes32) continue;
    EXPECT_EQ(of_width[0].largest, of_width[1].largest);
    EXPECT_EQ(of_width[0].mean_square, of_width[1].mean_square);
    EXPECT_EQ(of_width[0].decodings, 0);
    EXPECT_EQ(of_width[1].decodings, 0);
    EXPECT_EQ(of_width[0].decoded_blocks, of_width[1].decoded_blocks);
  }
}

// ---- a file that the workspace does not know is decoded ----

class OtherFilesTest : public LayerDecoderTest {
 protected:
  void SetUp() override {
    width = 150, height = 110;
    samples = depth_map(width, height, bits);
    mask = disc_mask(width, height, 0.4);
    params.max_bytes = 6000;
    params.layers = 3;
    ASSERT_TRUE(encode(samples, bits, mask.view(), params).ok());
    ASSERT_EQ(product.layers, 3);
    ASSERT_TRUE(measure_layer_errors(bytes(), samples.view(), mask.view(), *workspace, right).ok());
    ASSERT_TRUE(encode(samples, bits, mask.view(), params).ok());
  }
  void expect_decoded(std::span<const std::uint8_t> data) {
    ASSERT_TRUE(measure_layer_errors(data, samples.view(), mask.view(), *workspace, errors).ok());
    EXPECT_EQ(errors.decodings, errors.layers);
    EXPECT_EQ(errors.largest, right.largest);
    EXPECT_EQ(errors.mean_square, right.mean_square);
  }
  /// The offset of a marker in the file, and of the first packet.
  [[nodiscard]] std::size_t at(unsigned marker) const {
    for (std::size_t i = 0; i + 1 < product.bytes; ++i) {
      if (file[i] == marker >> 8U && file[i + 1] == (marker & 0xffU)) return i;
    }
    ADD_FAILURE() << "no marker " << marker;
    return 0;
  }

  Jpeg2000Params params;
  LayerErrors right;
};

TEST_F(OtherFilesTest, FromAnotherEncoding) {
  const std::vector<std::uint8_t> first(bytes().begin(), bytes().end());
  for (const int change : {200, 1}) {
    Depth other = samples;
    for (std::size_t i = 0; i < other.pixels.size(); i += 7) {
      other.pixels[i] = static_cast<std::uint16_t>(other.pixels[i] ^ change);
    }
    ASSERT_TRUE(encode(other, bits, mask.view(), params).ok());
    expect_decoded(first);
  }
}

TEST_F(OtherFilesTest, AfterTheWorkspaceWasUsedForOtherThings) {
  workspace->holds_coefficients = false;
  expect_decoded(bytes());
}

TEST_F(OtherFilesTest, WithoutTheRecordOfEveryPass) {
  workspace->pass_ends -= 1;
  expect_decoded(bytes());
}

// A library whose arithmetic coder cannot be read.
TEST_F(OtherFilesTest, WhoseCoderLeftNoRecordOfItsPasses) {
  for (PassEnd& end : place_of_pass_ends(*workspace).first(workspace->pass_ends)) end = {};
  ASSERT_TRUE(measure_layer_errors(bytes(), samples.view(), mask.view(), *workspace, errors).ok());
  EXPECT_GT(errors.decoded_blocks + errors.decodings, 0);
  EXPECT_EQ(errors.largest, right.largest);
  EXPECT_EQ(errors.mean_square, right.mean_square);
}

// An interval that ends at zero says of every cut pass that a byte may be missing.
TEST_F(OtherFilesTest, WithMoreDoubtfulBlocksThanThereIsRoomFor) {
  width = 600, height = 400;
  samples = depth_map(width, height, bits);
  mask = disc_mask(width, height, 0.9);
  params.max_bytes = 30000;
  const auto encode_again = [&] { ASSERT_TRUE(encode(samples, bits, mask.view(), params).ok()); };
  encode_again();
  ASSERT_TRUE(measure_layer_errors(bytes(), samples.view(), mask.view(), *workspace, right).ok());
  ASSERT_EQ(right.decodings, 0);
  encode_again();
  for (PassEnd& end : place_of_pass_ends(*workspace).first(workspace->pass_ends)) end.top = 0;
  ASSERT_TRUE(measure_layer_errors(bytes(), samples.view(), mask.view(), *workspace, errors).ok());
  EXPECT_EQ(errors.decoded_blocks, static_cast<int>(DoubtfulBlocks{}.blocks.size()));
  EXPECT_GT(errors.decodings, 0) << "the layers of the other blocks are decoded whole";
  EXPECT_EQ(errors.largest, right.largest);
  EXPECT_EQ(errors.mean_square, right.mean_square);
}

// With one resolution and one layer the order of packets says nothing: the decoder takes any.
TEST_F(OtherFilesTest, InAnotherOrderOfPackets) {
  params.layers = 1;
  params.wavelet_levels = 0;
  ASSERT_TRUE(encode(samples, bits, mask.view(), params).ok());
  ASSERT_TRUE(measure_layer_errors(bytes(), samples.view(), mask.view(), *workspace, right).ok());
  ASSERT_TRUE(encode(samples, bits, mask.view(), params).ok());
  const std::size_t order = at(0xff52) + 5;
  ASSERT_EQ(file[order], 0);
  file[order] = 1;
  expect_decoded(bytes());
}

TEST_F(OtherFilesTest, WhoseHeadersSayWhatOursDoNotAreRefused) {
  CodingStyle style;
  const std::span<const std::uint8_t> coded = codestream();
  ASSERT_TRUE(read_coding_style(coded, style).ok());
  const auto cod = static_cast<std::size_t>(file.data() + at(0xff52) - coded.data());
  const auto qcd = static_cast<std::size_t>(file.data() + at(0xff5c) - coded.data());
  const auto sot = static_cast<std::size_t>(file.data() + at(0xff90) - coded.data());
  // Of COD: precincts, order, transform of components, sides and style of code-blocks, irreversible transform.
  for (const std::size_t byte : {cod + 4, cod + 5, cod + 8, cod + 10, cod + 11, cod + 12, cod + 13, qcd + 4, sot + 9}) {
    std::vector<std::uint8_t> changed(coded.begin(), coded.end());
    changed[byte] ^= 1U;
    EXPECT_TRUE(read_coding_style(changed, style).is(StatusCode::parse_error)) << byte;
  }
  std::vector<std::uint8_t> longer(coded.begin(), coded.end());
  longer.push_back(0);
  EXPECT_TRUE(read_coding_style(longer, style).is(StatusCode::parse_error));
}

// Whatever packet headers say, the reader ends, stays inside its memory, and what it accepts fills the codestream.
TEST_F(OtherFilesTest, DamagedPacketHeadersAreRefusedOrFillTheCodestream) {
  const std::span<const std::uint8_t> coded = codestream();
  CodingStyle style;
  ASSERT_TRUE(read_coding_style(coded, style).ok());
  CodeBlocks blocks;
  lay_out_code_blocks(style, blocks);
  std::vector<CodeBlock> block_memory(blocks.block_count);
  std::vector<TagNode> node_memory(blocks.node_count);
  blocks.blocks = block_memory;
  blocks.nodes = node_memory;
  ASSERT_TRUE(read_packet_headers(coded, style, blocks).ok());
  Rng rng(11);
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::uint8_t> changed(coded.begin(), coded.end());
    const std::size_t at_byte =
        style.data + rng.below(i % 2 == 0 ? 40 : static_cast<std::uint32_t>(style.data_end - style.data));
    changed[at_byte] = static_cast<std::uint8_t>(rng.below(256));
    const Status status = read_packet_headers(changed, style, blocks);
    if (!status.ok()) {
      EXPECT_TRUE(status.is(StatusCode::parse_error));
      ++refused;
      continue;
    }
    for (const CodeBlock& block : block_memory) {
      for (std::size_t layer = 0; layer < static_cast<std::size_t>(style.layers); ++layer) {
        const std::uint32_t before = layer == 0 ? 0 : block.bytes[layer - 1];
        ASSERT_LE(block.data[layer] + (block.bytes[layer] - before), style.data_end);
      }
    }
  }
  EXPECT_GT(refused, 200) << "only damage to the data itself may go unseen";
}

}  // namespace
}  // namespace ilp
