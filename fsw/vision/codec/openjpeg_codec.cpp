#include "fsw/vision/codec/openjpeg_codec.hpp"

#include <openjpeg.h>

#include <algorithm>
#include <array>
#include <bit>
#include <bitset>
#include <cstring>
#include <limits>

#include "cfg/limits.hpp"
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

// OpenJPEG starts its arithmetic coder for each code-block and asks it for the number of its bytes after each pass. The
// coder begins with its registers C, A and CT; where they do not have their initial values there after the start, or
// impossible ones later, nothing is recorded.
extern "C" void __real_opj_mqc_init_enc(void* coder, std::uint8_t* data);
extern "C" void __wrap_opj_mqc_init_enc(void* coder, std::uint8_t* data);
extern "C" std::uint32_t __real_opj_mqc_numbytes(void* coder);
extern "C" std::uint32_t __wrap_opj_mqc_numbytes(void* coder);

namespace ilp {
namespace {

struct CoderRegisters {
  std::uint32_t c, a, ct;
};

struct PassRecorder {
  PassEnds* ends = nullptr;
  const std::uint8_t* data = nullptr;  ///< of the code-block; null if the registers cannot be read
};
thread_local PassRecorder pass_recorder;

CoderRegisters registers_of(const void* coder) {
  CoderRegisters registers{};
  std::memcpy(&registers, coder, sizeof(registers));
  return registers;
}

PassEnd pass_end(const CoderRegisters& registers, std::uint32_t last, const std::uint8_t* data) {
  constexpr std::uint32_t no_byte = 0xffffffff, most_bytes = 0xffff;
  const bool possible = registers.a >= 0x8000 && registers.a <= 0xffff && registers.ct >= 1 && registers.ct <= 12 &&
                        registers.c < (std::uint32_t{1} << 28U);
  if (data == nullptr || !possible || (last != no_byte && last >= most_bytes)) return {};
  PassEnd end;
  end.top = (registers.c + registers.a) << registers.ct;
  end.bytes = static_cast<std::uint16_t>(last + 1);
  end.last_byte = last == no_byte ? 0 : data[last];
  return end;
}

}  // namespace
}  // namespace ilp

extern "C" void __wrap_opj_mqc_init_enc(void* coder, std::uint8_t* data) {
  __real_opj_mqc_init_enc(coder, data);
  const ilp::CoderRegisters registers = ilp::registers_of(coder);
  const bool initial = registers.c == 0 && registers.a == 0x8000 && registers.ct == 12;
  ilp::pass_recorder.data = initial ? data : nullptr;
}

extern "C" std::uint32_t __wrap_opj_mqc_numbytes(void* coder) {
  const std::uint32_t last = __real_opj_mqc_numbytes(coder);
  ilp::PassEnds* const ends = ilp::pass_recorder.ends;
  if (ends == nullptr) return last;
  if (ends->count < ends->room.size()) {
    ends->room[ends->count] = ilp::pass_end(ilp::registers_of(coder), last, ilp::pass_recorder.data);
  }
  ++ends->count;
  return last;
}

#if OPJ_VERSION_BUILD == 0
// OpenJPEG 2.5.0 finds the passes of a layer by 128 halvings of the interval from the least to the greatest slope, and
// puts all packets together at each of them, which takes longer than coding. It is answered without that in two cases:
// - Thirty-two halvings after the first threshold that was too low, and after 64 at most, the interval is 2^-32 of the
//   threshold. From then on the answer is "too long": the last threshold that was short enough stays, and a layer lacks
//   at worst the passes whose slopes lie in that interval.
// - A layer has no passes of its own at the thresholds that were high enough for the layer before it. The search comes
//   by them first, and all of them have the answer of the first one.
// Later versions end the search when the interval is 1e-5 of the threshold, and put packets together only where other
// passes are chosen.
extern "C" int __real_opj_t2_encode_packets(void* encoder, std::uint32_t tile_number, void* tile, std::uint32_t layers,
                                            std::uint8_t* bytes, std::uint32_t* written, std::uint32_t room,
                                            void* index, void* markers, std::uint32_t part, std::int32_t part_position,
                                            std::uint32_t progression, unsigned mode, void* events);
extern "C" int __wrap_opj_t2_encode_packets(void* encoder, std::uint32_t tile_number, void* tile, std::uint32_t layers,
                                            std::uint8_t* bytes, std::uint32_t* written, std::uint32_t room,
                                            void* index, void* markers, std::uint32_t part, std::int32_t part_position,
                                            std::uint32_t progression, unsigned mode, void* events);

namespace ilp {
namespace {

class LayerSearch {
 public:
  void begin_layer(std::uint32_t layers) {
    if (layers == layers_) return;
    follows_ = layers == layers_ + 1 && answers_[0];
    answers_before_ = answers_;
    answers_.reset();
    layers_ = layers;
    step_ = 0;
    last_step_ = most_halvings;
  }
  /// Nothing is put together any more.
  [[nodiscard]] bool ended() const { return step_ >= last_step_; }
  /// The threshold was high enough for the layer before, and an earlier one was so for this layer.
  [[nodiscard]] bool adds_nothing() const { return follows_ && step_ > 0 && answers_before_[step_]; }
  void answer(bool short_enough) {
    if (!short_enough && last_step_ == most_halvings) last_step_ = std::min(most_halvings, step_ + 1 + more_halvings);
    follows_ = follows_ && short_enough == answers_before_[step_];
    answers_[step_] = short_enough;
    ++step_;
  }

 private:
  static constexpr std::size_t most_halvings = 64, more_halvings = 32;
  std::uint32_t layers_ = 0;
  std::size_t step_ = 0, last_step_ = most_halvings;
  std::bitset<most_halvings> answers_, answers_before_;
  bool follows_ = false;  ///< all answers were those for the layer before
};
thread_local LayerSearch layer_search;

}  // namespace
}  // namespace ilp

extern "C" int __wrap_opj_t2_encode_packets(void* encoder, std::uint32_t tile_number, void* tile, std::uint32_t layers,
                                            std::uint8_t* bytes, std::uint32_t* written, std::uint32_t room,
                                            void* index, void* markers, std::uint32_t part, std::int32_t part_position,
                                            std::uint32_t progression, unsigned mode, void* events) {
  const auto put_together = [&] {
    return __real_opj_t2_encode_packets(encoder, tile_number, tile, layers, bytes, written, room, index, markers, part,
                                        part_position, progression, mode, events);
  };
  constexpr unsigned searching = 0;
  if (mode != searching) return put_together();
  auto& search = ilp::layer_search;
  search.begin_layer(layers);
  if (search.ended()) return OPJ_FALSE;
  const int short_enough = search.adds_nothing() ? OPJ_TRUE : put_together();
  search.answer(short_enough == OPJ_TRUE);
  return short_enough;
}
#endif
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
    const std::size_t room = out.bytes.size() - out.position;
    std::memcpy(out.bytes.data() + out.position, data, count < room ? count : room);
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
  bool allow_truncated;
  int layers;
  ImageView<std::int32_t> samples;
  Status status;
};

Status copy_component(const opj_image_t& image, ImageView<std::int32_t> samples) {
  if (image.numcomps != 1 || image.comps[0].data == nullptr) return failed_at(CodecStage::finish);
  const opj_image_comp_t& component = image.comps[0];
  if (component.w != static_cast<OPJ_UINT32>(samples.width) || component.h != static_cast<OPJ_UINT32>(samples.height)) {
    return failed_at(CodecStage::finish);
  }
  for (std::int32_t y = 0; y < samples.height; ++y) {
    std::memcpy(samples.row(y), component.data + static_cast<std::ptrdiff_t>(y) * samples.width,
                static_cast<std::size_t>(samples.width) * sizeof(std::int32_t));
  }
  return {};
}

Status run_decoder(DecodeCall& call, Handles& handles) {
  opj_dparameters_t parameters;
  opj_set_default_decoder_parameters(&parameters);
  parameters.cp_layer = static_cast<OPJ_UINT32>(call.layers);
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
  if (opj_decoder_set_strict_mode(handles.codec, call.allow_truncated ? OPJ_FALSE : OPJ_TRUE) == OPJ_FALSE) {
    return failed_at(CodecStage::setup);
  }
  if (opj_read_header(handles.stream, handles.codec, &handles.image) == OPJ_FALSE) return failed_at(CodecStage::header);
  if (opj_decode(handles.codec, handles.stream, handles.image) == OPJ_FALSE) return failed_at(CodecStage::code);
  if (opj_end_decompress(handles.codec, handles.stream) == OPJ_FALSE && !call.allow_truncated) {
    return failed_at(CodecStage::finish);
  }
  return copy_component(*handles.image, call.samples);
}

void decode_call(void* context) {
  auto& call = *static_cast<DecodeCall*>(context);
  Handles handles;
  call.status = run_decoder(call, handles);
  release(handles);
}

struct MemoryCall {
  std::size_t bytes;
  void (*body)(std::span<std::uint8_t> memory, void* context);
  void* context;
  Status status;
};

void memory_call(void* context) {
  auto& call = *static_cast<MemoryCall*>(context);
  void* const memory = opj_image_data_alloc(call.bytes);
  if (memory == nullptr) {
    call.status = StatusCode::arena_exhausted;
    return;
  }
  call.body({static_cast<std::uint8_t*>(memory), call.bytes}, call.context);
  opj_image_data_free(memory);
}

}  // namespace

Status with_openjpeg_memory(std::size_t bytes, void (*body)(std::span<std::uint8_t> memory, void* context),
                            void* context) {
  MemoryCall call{bytes, body, context, {}};
  ILP_TRY(call_in_heap_region(HeapRegion::openjpeg, memory_call, &call));
  return call.status;
}

Status openjpeg_encode(ImageView<const std::int32_t> samples, const CodestreamParams& params,
                       std::span<std::uint8_t> out, std::size_t& bytes, PassEnds* pass_ends) {
  if (pass_ends != nullptr) pass_ends->count = 0;
  pass_recorder = {pass_ends, nullptr};
#if OPJ_VERSION_BUILD == 0
  layer_search = {};
#endif
  samples_are_coefficients = params.transformed;
  EncodeCall call{samples, params, {out, 0, 0}, {}};
  ILP_TRY(call_in_heap_region(HeapRegion::openjpeg, encode_call, &call));
  pass_recorder = {};
  bytes = call.out.end;
  return call.status;
}

Status openjpeg_decode(std::span<const std::uint8_t> codestream, bool allow_truncated, int layers,
                       ImageView<std::int32_t> samples) {
  DecodeCall call{{codestream, 0}, allow_truncated, layers, samples, {}};
  ILP_TRY(call_in_heap_region(HeapRegion::openjpeg, decode_call, &call));
  return call.status;
}

}  // namespace ilp
