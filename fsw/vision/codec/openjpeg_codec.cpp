#include "fsw/vision/codec/openjpeg_codec.hpp"

#include <openjpeg.h>

#include <array>
#include <bit>
#include <cstring>
#include <limits>

#include "cfg/limits.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/base/heap_gate.hpp"

// OpenJPEG cuts layers by sums of w * w * n, w being the norm of a band times a power of two and n an integer below
// 2^31. A compiler may round the product before it is added, or not (fused multiply-add, as Debian has it for aarch64),
// and passes that are worth the same then lie in one layer or the other. With norms of 11 significant bits the products
// are exact: every machine has the same sums. The linker puts __wrap_... in place of the library's function.
// NOLINTBEGIN(bugprone-reserved-identifier)
extern "C" double __real_opj_dwt_getnorm(std::uint32_t level, std::uint32_t orientation);
extern "C" double __wrap_opj_dwt_getnorm(std::uint32_t level, std::uint32_t orientation);

extern "C" double __wrap_opj_dwt_getnorm(std::uint32_t level, std::uint32_t orientation) {
  constexpr int dropped_bits = std::numeric_limits<double>::digits - 11;
  const auto bits = std::bit_cast<std::uint64_t>(__real_opj_dwt_getnorm(level, orientation));
  const std::uint64_t rounded = bits + (std::uint64_t{1} << (dropped_bits - 1));
  return std::bit_cast<double>(rounded >> dropped_bits << dropped_bits);
}

// Where the samples are coefficients already, the library's own transform is left out.
extern "C" int __real_opj_dwt_encode(void* coder, void* component);
extern "C" int __wrap_opj_dwt_encode(void* coder, void* component);

namespace ilp {
namespace {

thread_local bool samples_are_coefficients = false;

}  // namespace
}  // namespace ilp

extern "C" int __wrap_opj_dwt_encode(void* coder, void* component) {
  return ilp::samples_are_coefficients ? OPJ_TRUE : __real_opj_dwt_encode(coder, component);
}

// NOLINTEND(bugprone-reserved-identifier)

namespace ilp {
namespace {

constexpr OPJ_SIZE_T stream_buffer_bytes = 65536;

void keep_silent(const char*, void*) {}

// ---- a fixed buffer as OpenJPEG's stream ----

struct OutputBuffer {
  std::span<std::uint8_t> bytes;
  std::size_t position = 0;
  std::size_t end = 0;
};

// Bytes beyond the buffer are only counted, so that the caller learns the full size.
OPJ_SIZE_T write_bytes(void* data, OPJ_SIZE_T count, void* user) {
  auto& out = *static_cast<OutputBuffer*>(user);
  if (out.position < out.bytes.size()) {
    const std::size_t capacity = out.bytes.size() - out.position;
    std::memcpy(out.bytes.data() + out.position, data, count < capacity ? count : capacity);
  }
  out.position += count;
  if (out.position > out.end) out.end = out.position;
  return count;
}

OPJ_OFF_T skip_output(OPJ_OFF_T count, void* user) {
  auto& out = *static_cast<OutputBuffer*>(user);
  if (count < 0 && static_cast<std::size_t>(-count) > out.position) return -1;
  out.position = static_cast<std::size_t>(static_cast<OPJ_OFF_T>(out.position) + count);
  return count;
}

OPJ_BOOL seek_output(OPJ_OFF_T position, void* user) {
  if (position < 0) return OPJ_FALSE;
  static_cast<OutputBuffer*>(user)->position = static_cast<std::size_t>(position);
  return OPJ_TRUE;
}

struct InputBuffer {
  std::span<const std::uint8_t> bytes;
  std::size_t position = 0;
};

OPJ_SIZE_T read_bytes(void* data, OPJ_SIZE_T count, void* user) {
  auto& in = *static_cast<InputBuffer*>(user);
  const std::size_t left = in.bytes.size() - in.position;
  if (left == 0) return static_cast<OPJ_SIZE_T>(-1);
  const std::size_t taken = count < left ? count : left;
  std::memcpy(data, in.bytes.data() + in.position, taken);
  in.position += taken;
  return taken;
}

OPJ_OFF_T skip_input(OPJ_OFF_T count, void* user) {
  auto& in = *static_cast<InputBuffer*>(user);
  const auto left = static_cast<OPJ_OFF_T>(in.bytes.size() - in.position);
  if (count < 0 || left == 0) return -1;
  const OPJ_OFF_T taken = count < left ? count : left;
  in.position += static_cast<std::size_t>(taken);
  return taken;
}

OPJ_BOOL seek_input(OPJ_OFF_T position, void* user) {
  auto& in = *static_cast<InputBuffer*>(user);
  if (position < 0 || static_cast<std::size_t>(position) > in.bytes.size()) return OPJ_FALSE;
  in.position = static_cast<std::size_t>(position);
  return OPJ_TRUE;
}

// Objects of a call into OpenJPEG. They have no destructors, because the heap gate may abandon the call anywhere.
struct Handles {
  opj_codec_t* codec = nullptr;
  opj_stream_t* stream = nullptr;
  opj_image_t* image = nullptr;
};

void release(const Handles& handles) {
  if (handles.stream != nullptr) opj_stream_destroy(handles.stream);
  if (handles.codec != nullptr) opj_destroy_codec(handles.codec);
  if (handles.image != nullptr) opj_image_destroy(handles.image);
}

void silence(opj_codec_t* codec) {
  opj_set_error_handler(codec, keep_silent, nullptr);
  opj_set_warning_handler(codec, keep_silent, nullptr);
  opj_set_info_handler(codec, keep_silent, nullptr);
}

Status failed_at(CodecStage stage) {
  return {StatusCode::codec_failed, 0, static_cast<std::int64_t>(stage)};
}

// ---- encoding ----

struct EncodeCall {
  ImageView<const std::int32_t> samples;
  const CodestreamParams& params;
  OutputBuffer out;
  Status status;
};

opj_image_t* make_image(ImageView<const std::int32_t> samples, int bits) {
  opj_image_cmptparm_t component = {};
  component.dx = 1;
  component.dy = 1;
  component.w = static_cast<OPJ_UINT32>(samples.width);
  component.h = static_cast<OPJ_UINT32>(samples.height);
  component.prec = static_cast<OPJ_UINT32>(bits);
  component.sgnd = 1;
  opj_image_t* image = opj_image_create(1, &component, OPJ_CLRSPC_GRAY);
  if (image == nullptr) return nullptr;
  image->x1 = component.w;
  image->y1 = component.h;
  for (std::int32_t y = 0; y < samples.height; ++y) {
    std::memcpy(image->comps[0].data + static_cast<std::ptrdiff_t>(y) * samples.width, samples.row(y),
                static_cast<std::size_t>(samples.width) * sizeof(std::int32_t));
  }
  return image;
}

void set_parameters(const EncodeCall& call, char* comment, opj_cparameters_t& parameters) {
  opj_set_default_encoder_parameters(&parameters);
  // The library's own comment contains its version, on which files must not depend.
  parameters.cp_comment = comment;
  parameters.irreversible = 0;
  parameters.numresolution = call.params.wavelet_levels + 1;
  parameters.prog_order = OPJ_LRCP;
  parameters.cp_disto_alloc = 1;
  if (call.params.shift > 0) {
    parameters.roi_compno = 0;
    parameters.roi_shift = call.params.shift;
  }
  parameters.tcp_numlayers = static_cast<int>(call.params.layer_bytes.size());
  const double raw_bytes = static_cast<double>(call.samples.area()) * call.params.bits / 8;
  for (std::size_t i = 0; i < call.params.layer_bytes.size(); ++i) {
    const double target = call.params.layer_bytes[i];
    parameters.tcp_rates[i] = target > 0 ? static_cast<float>(raw_bytes / target) : 0.0F;
  }
}

Status set_up_encoder(const EncodeCall& call, Handles& handles) {
  char comment[] = "ILP";
  // Larger than what a stack should hold.
  void* const memory = opj_image_data_alloc(sizeof(opj_cparameters_t));
  if (memory == nullptr) return failed_at(CodecStage::setup);
  auto& parameters = *static_cast<opj_cparameters_t*>(memory);
  set_parameters(call, comment, parameters);
  const OPJ_BOOL taken = opj_setup_encoder(handles.codec, &parameters, handles.image);
  opj_image_data_free(memory);
  return taken == OPJ_FALSE ? failed_at(CodecStage::setup) : Status{};
}

Status run_encoder(EncodeCall& call, Handles& handles) {
  handles.image = make_image(call.samples, call.params.bits);
  handles.codec = opj_create_compress(OPJ_CODEC_J2K);
  handles.stream = opj_stream_create(stream_buffer_bytes, OPJ_FALSE);
  if (handles.image == nullptr || handles.codec == nullptr || handles.stream == nullptr) {
    return failed_at(CodecStage::setup);
  }
  silence(handles.codec);
  opj_stream_set_user_data(handles.stream, &call.out, nullptr);
  opj_stream_set_write_function(handles.stream, write_bytes);
  opj_stream_set_skip_function(handles.stream, skip_output);
  opj_stream_set_seek_function(handles.stream, seek_output);
  ILP_TRY(set_up_encoder(call, handles));
  const char* const options[] = {"PLT=YES", nullptr};
  if (call.params.packet_lengths && opj_encoder_set_extra_options(handles.codec, options) == OPJ_FALSE) {
    return failed_at(CodecStage::setup);
  }
  if (opj_start_compress(handles.codec, handles.image, handles.stream) == OPJ_FALSE) {
    return failed_at(CodecStage::start);
  }
  if (opj_encode(handles.codec, handles.stream) == OPJ_FALSE) return failed_at(CodecStage::code);
  if (opj_end_compress(handles.codec, handles.stream) == OPJ_FALSE) return failed_at(CodecStage::finish);
  return {};
}

void encode_call(void* context) {
  auto& call = *static_cast<EncodeCall*>(context);
  Handles handles;
  call.status = run_encoder(call, handles);
  release(handles);
}

// ---- decoding ----

struct DecodeCall {
  InputBuffer in;
  const Decoding& decoding;
  Status status;
};

Status hand_over(const opj_image_t& image, const Decoding& decoding) {
  if (image.numcomps != 1 || image.comps[0].data == nullptr) return failed_at(CodecStage::finish);
  const opj_image_comp_t& component = image.comps[0];
  const auto width = static_cast<OPJ_UINT32>(decoding.width), height = static_cast<OPJ_UINT32>(decoding.height);
  if (component.w != width || component.h != height) return failed_at(CodecStage::finish);
  decoding.take({component.data, decoding.width, decoding.height}, decoding.context);
  return {};
}

Status run_decoder(DecodeCall& call, Handles& handles) {
  opj_dparameters_t parameters;
  opj_set_default_decoder_parameters(&parameters);
  parameters.cp_layer = static_cast<OPJ_UINT32>(call.decoding.layers);
  handles.codec = opj_create_decompress(OPJ_CODEC_J2K);
  handles.stream = opj_stream_create(stream_buffer_bytes, OPJ_TRUE);
  if (handles.codec == nullptr || handles.stream == nullptr) return failed_at(CodecStage::setup);
  silence(handles.codec);
  opj_stream_set_user_data(handles.stream, &call.in, nullptr);
  opj_stream_set_user_data_length(handles.stream, call.in.bytes.size());
  opj_stream_set_read_function(handles.stream, read_bytes);
  opj_stream_set_skip_function(handles.stream, skip_input);
  opj_stream_set_seek_function(handles.stream, seek_input);
  if (opj_setup_decoder(handles.codec, &parameters) == OPJ_FALSE) return failed_at(CodecStage::setup);
  if (opj_decoder_set_strict_mode(handles.codec, call.decoding.allow_truncated ? OPJ_FALSE : OPJ_TRUE) == OPJ_FALSE) {
    return failed_at(CodecStage::setup);
  }
  if (opj_read_header(handles.stream, handles.codec, &handles.image) == OPJ_FALSE) return failed_at(CodecStage::header);
  if (opj_decode(handles.codec, handles.stream, handles.image) == OPJ_FALSE) return failed_at(CodecStage::code);
  if (opj_end_decompress(handles.codec, handles.stream) == OPJ_FALSE && !call.decoding.allow_truncated) {
    return failed_at(CodecStage::finish);
  }
  return hand_over(*handles.image, call.decoding);
}

void decode_call(void* context) {
  auto& call = *static_cast<DecodeCall*>(context);
  Handles handles;
  call.status = run_decoder(call, handles);
  release(handles);
}

}  // namespace

Status openjpeg_encode(ImageView<const std::int32_t> samples, const CodestreamParams& params,
                       std::span<std::uint8_t> out, std::size_t& bytes) {
  samples_are_coefficients = params.transformed;
  EncodeCall call{samples, params, {out, 0, 0}, {}};
  ILP_TRY(call_in_heap_region(HeapRegion::openjpeg, encode_call, &call));
  bytes = call.out.end;
  return call.status;
}

Status openjpeg_decode(std::span<const std::uint8_t> codestream, const Decoding& decoding) {
  DecodeCall call{{codestream, 0}, decoding, {}};
  ILP_TRY(call_in_heap_region(HeapRegion::openjpeg, decode_call, &call));
  return call.status;
}

std::uint32_t openjpeg_digest() {
  static_assert(OPJ_VERSION_MAJOR < 10 && OPJ_VERSION_MINOR < 10 && OPJ_VERSION_BUILD < 10);
  constexpr char version[] = {'0' + OPJ_VERSION_MAJOR, '.', '0' + OPJ_VERSION_MINOR, '.', '0' + OPJ_VERSION_BUILD, 0};
  if (std::strcmp(opj_version(), version) != 0) return 0;
  constexpr std::int32_t side = 32;
  constexpr double layer_bytes[] = {100, 140, 200, 280, 400, 560};
  CodestreamParams params;
  params.wavelet_levels = 2;
  params.transformed = true;
  params.packet_lengths = true;
  params.layer_bytes = layer_bytes;
  params.shift = 6;
  params.bits = 8 + params.shift;
  // Coefficients of a slope and of noise; those of the region are above all others.
  std::array<std::int32_t, std::size_t{side} * side> samples;
  for (std::int32_t i = 0; i < side * side; ++i) {
    const std::int32_t x = i % side, y = i / side;
    const std::int32_t value =
        (x * y * 37 + x * x * 11 + y * 5) % 61 - 30 + (x < side / 4 && y < side / 4 ? 3 * x + y : 0);
    const bool region = (x / 2 + y) % 3 == 0;
    samples[static_cast<std::size_t>(i)] = region ? value * (1 << params.shift) : value;
  }
  std::array<std::uint8_t, 2048> codestream;
  std::size_t bytes = 0;
  const Status status = openjpeg_encode({samples.data(), side, side}, params, codestream, bytes);
  return status.ok() && bytes <= codestream.size() ? crc32(std::span(codestream).first(bytes)) : 0;
}

}  // namespace ilp
