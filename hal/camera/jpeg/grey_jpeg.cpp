#include "hal/camera/jpeg/grey_jpeg.hpp"

// jpeglib.h needs FILE.
#include <cstdio>
// The first one must be read first.
#include <jpeglib.h>

#include "fsw/base/heap_gate.hpp"
#include "fsw/base/status_values.hpp"

namespace ilp {
namespace {

// libjpeg has an arena of its own: its malloc is that of HeapRegion::jpeg. It reports an error by a function that must
// not return; here this function leaves call_abandonable(), after which libjpeg releases what it has allocated.
struct Call {
  std::span<const std::uint8_t> file;
  std::int32_t width, height;
  std::uint8_t* row;
  RowReducer* rows;
  Status status;
  jpeg_error_mgr errors;
  jpeg_source_mgr source;
  jpeg_decompress_struct decoder;
};

[[noreturn]] void abandon(Call& call, const Status& status) {
  call.status = status;
  abandon_heap_call();
  // There always is a call to abandon.
  __builtin_trap();
}

Call& call_of(void* client_data) {
  return *static_cast<Call*>(client_data);
}

[[noreturn]] void refuse(j_common_ptr decoder) {
  abandon(call_of(decoder->client_data), {StatusCode::parse_error, decoder->err->msg_code});
}

/// Warnings are below 0: the decoder has found the file damaged and would go on with a guess.
void refuse_warning(j_common_ptr decoder, int level) {
  if (level < 0) refuse(decoder);
}

void say_nothing(j_common_ptr) {}

void begin_source(j_decompress_ptr) {}

boolean end_of_file(j_decompress_ptr decoder) {
  abandon(call_of(decoder->client_data), {StatusCode::truncated, decoder->output_scanline});
}

void skip(j_decompress_ptr decoder, long bytes) {
  if (bytes <= 0) return;
  const auto count = static_cast<std::size_t>(bytes);
  if (count > decoder->src->bytes_in_buffer) end_of_file(decoder);
  decoder->src->next_input_byte += count;
  decoder->src->bytes_in_buffer -= count;
}

boolean refuse_restart(j_decompress_ptr decoder, int) {
  abandon(call_of(decoder->client_data), {StatusCode::parse_error, -1});
}

void attach(Call& call) {
  call.source.next_input_byte = call.file.data();
  call.source.bytes_in_buffer = call.file.size();
  call.source.init_source = begin_source;
  call.source.fill_input_buffer = end_of_file;
  call.source.skip_input_data = skip;
  call.source.resync_to_restart = refuse_restart;
  call.source.term_source = begin_source;
  call.decoder.src = &call.source;
}

void check_header(Call& call) {
  const jpeg_decompress_struct& header = call.decoder;
  if (header.image_width != static_cast<JDIMENSION>(call.width) ||
      header.image_height != static_cast<JDIMENSION>(call.height)) {
    abandon(call, {StatusCode::image_size_changed, header.image_width, header.image_height});
  }
  const bool whole_picture = header.progressive_mode != FALSE || jpeg_has_multiple_scans(&call.decoder) != FALSE;
  if (whole_picture || header.arith_code != FALSE) abandon(call, not_supported(FormatFault::jpeg_coding));
}

void read_rows(void* context) {
  Call& call = call_of(context);
  jpeg_decompress_struct& decoder = call.decoder;
  attach(call);
  static_cast<void>(jpeg_read_header(&decoder, TRUE));
  check_header(call);
  decoder.out_color_space = JCS_GRAYSCALE;
  // Exact integers, the same on every machine.
  decoder.dct_method = JDCT_ISLOW;
  decoder.do_fancy_upsampling = FALSE;
  decoder.do_block_smoothing = FALSE;
  static_cast<void>(jpeg_start_decompress(&decoder));
  // The source never suspends, so that every turn gives a row.
  for (std::int32_t y = 0; y < call.height; ++y) {
    JSAMPROW row = call.row;
    static_cast<void>(jpeg_read_scanlines(&decoder, &row, 1));
    call.rows->add({call.row, static_cast<std::size_t>(call.width)});
  }
}

void decode(void* context) {
  Call& call = call_of(context);
  call.decoder.err = jpeg_std_error(&call.errors);
  call.errors.error_exit = refuse;
  call.errors.emit_message = refuse_warning;
  call.errors.output_message = say_nothing;
  call.decoder.client_data = &call;
  jpeg_create_decompress(&call.decoder);
  static_cast<void>(call_abandonable(read_rows, &call));
  jpeg_destroy_decompress(&call.decoder);
}

}  // namespace

Status decode_grey_jpeg(std::span<const std::uint8_t> file, std::int32_t width, std::int32_t height,
                        std::span<std::uint8_t> row, RowReducer& rows) {
  if (width < 1 || height < 1 || row.size() < static_cast<std::size_t>(width)) {
    return {StatusCode::image_too_large, width, height};
  }
  Call call{};
  call.file = file;
  call.width = width;
  call.height = height;
  call.row = row.data();
  call.rows = &rows;
  ILP_TRY(call_in_heap_region(HeapRegion::jpeg, decode, &call));
  return call.status;
}

}  // namespace ilp
