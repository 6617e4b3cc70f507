#include "fsw/vision/codec/jp2_file.hpp"

#include <cstring>

namespace ilp {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::uint32_t box_type(const char (&name)[5]) {
  std::uint32_t type = 0;
  for (int i = 0; i < 4; ++i) type = (type << 8U) | static_cast<std::uint8_t>(name[i]);
  return type;
}

constexpr std::uint32_t box_signature = box_type("jP  ");
constexpr std::uint32_t box_file_type = box_type("ftyp");
constexpr std::uint32_t box_header = box_type("jp2h");
constexpr std::uint32_t box_image_header = box_type("ihdr");
constexpr std::uint32_t box_colour = box_type("colr");
constexpr std::uint32_t box_uuid = box_type("uuid");
constexpr std::uint32_t box_codestream = box_type("jp2c");
constexpr std::uint32_t brand = box_type("jp2 ");

constexpr unsigned marker_soc = 0xff4f, marker_siz = 0xff51, marker_cod = 0xff52, marker_qcd = 0xff5c;
constexpr unsigned marker_eoc = 0xffd9;
constexpr unsigned marker_plt = 0xff58, marker_sot = 0xff90, marker_sod = 0xff93;

constexpr std::size_t box_head = 8;
constexpr std::size_t signature_bytes = 12;
constexpr std::size_t file_type_bytes = 20;
constexpr std::size_t image_header_bytes = 22;
constexpr std::size_t colour_bytes = 15;
constexpr std::size_t header_bytes = box_head + image_header_bytes + colour_bytes;

constexpr std::uint32_t greyscale = 17;
constexpr std::uint8_t compression_jpeg2000 = 7;

unsigned get16(Bytes b, std::size_t at) {
  return static_cast<unsigned>(b[at] << 8U) | b[at + 1];
}

std::uint32_t get32(Bytes b, std::size_t at) {
  return (static_cast<std::uint32_t>(get16(b, at)) << 16U) | get16(b, at + 2);
}

void put16(std::span<std::uint8_t> b, std::size_t at, unsigned value) {
  b[at] = static_cast<std::uint8_t>(value >> 8U);
  b[at + 1] = static_cast<std::uint8_t>(value);
}

void put32(std::span<std::uint8_t> b, std::size_t at, std::uint32_t value) {
  put16(b, at, value >> 16U);
  put16(b, at + 2, value & 0xffffU);
}

Status malformed(std::size_t offset) {
  return {StatusCode::parse_error, static_cast<std::int64_t>(offset), 0};
}

struct Writer {
  std::span<std::uint8_t> bytes;
  std::size_t at = 0;
  void u8(std::uint8_t value) { bytes[at++] = value; }
  void u16(unsigned value) {
    put16(bytes, at, value);
    at += 2;
  }
  void u32(std::uint32_t value) {
    put32(bytes, at, value);
    at += 4;
  }
  void copy(Bytes from) {
    if (from.empty()) return;
    std::memcpy(bytes.data() + at, from.data(), from.size());
    at += from.size();
  }
  void box(std::size_t length, std::uint32_t type) {
    u32(static_cast<std::uint32_t>(length));
    u32(type);
  }
};

// Walks the marker segments of a header. `at` stands on a marker; each segment lies wholly inside the codestream.
struct Segment {
  unsigned marker = 0;
  std::size_t length = 0;  // as written: without the marker
};

Status segment_at(Bytes codestream, std::size_t at, Segment& segment) {
  if (at + 4 > codestream.size()) return {StatusCode::truncated, static_cast<std::int64_t>(at), 0};
  segment = {get16(codestream, at), get16(codestream, at + 2)};
  if (segment.marker < 0xff00 || segment.length < 2) return malformed(at);
  if (at + 2 + segment.length > codestream.size()) return {StatusCode::truncated, static_cast<std::int64_t>(at), 0};
  return {};
}

struct Siz {
  std::uint32_t x1, y1, x0, y0, tile_width, tile_height, tile_x0, tile_y0;
  unsigned components;
  unsigned precision;
  unsigned step_x, step_y;
};

Status read_siz(Bytes codestream, Siz& siz) {
  if (codestream.size() < 2 || get16(codestream, 0) != marker_soc) return malformed(0);
  Segment segment;
  ILP_TRY(segment_at(codestream, 2, segment));
  if (segment.marker != marker_siz || segment.length < 41) return malformed(2);
  const std::size_t at = 8;
  siz = {get32(codestream, at),      get32(codestream, at + 4),  get32(codestream, at + 8),  get32(codestream, at + 12),
         get32(codestream, at + 16), get32(codestream, at + 20), get32(codestream, at + 24), get32(codestream, at + 28),
         get16(codestream, at + 32), codestream[at + 34],        codestream[at + 35],        codestream[at + 36]};
  return {};
}

constexpr std::uint64_t ceil_div(std::uint64_t a, std::uint64_t b) {
  return (a + b - 1) / b;
}

Status describe_image(const Siz& siz, Jpeg2000Info& info) {
  constexpr std::uint64_t max_pixels = std::uint64_t{1} << 28U;
  constexpr std::uint64_t max_tiles = 1024;
  constexpr int max_bits = 25;
  if (siz.components != 1) return {StatusCode::unsupported_format, siz.components};
  if (siz.step_x == 0 || siz.step_y == 0 || siz.x1 <= siz.x0 || siz.y1 <= siz.y0 || siz.tile_width == 0 ||
      siz.tile_height == 0 || siz.tile_x0 > siz.x0 || siz.tile_y0 > siz.y0) {
    return malformed(2);
  }
  const std::uint64_t width = ceil_div(siz.x1, siz.step_x) - ceil_div(siz.x0, siz.step_x);
  const std::uint64_t height = ceil_div(siz.y1, siz.step_y) - ceil_div(siz.y0, siz.step_y);
  if (width == 0 || height == 0) return malformed(2);
  if (width > max_pixels || height > max_pixels || width * height > max_pixels) {
    return {StatusCode::unsupported_format, static_cast<std::int64_t>(width), static_cast<std::int64_t>(height)};
  }
  const std::uint64_t tiles =
      ceil_div(siz.x1 - siz.tile_x0, siz.tile_width) * ceil_div(siz.y1 - siz.tile_y0, siz.tile_height);
  if (tiles > max_tiles) return {StatusCode::unsupported_format, static_cast<std::int64_t>(tiles)};
  info.width = static_cast<std::int32_t>(width);
  info.height = static_cast<std::int32_t>(height);
  info.is_signed = (siz.precision & 0x80U) != 0;
  info.bits = static_cast<int>(siz.precision & 0x7fU) + 1;
  if (info.bits > max_bits) return {StatusCode::unsupported_format, info.bits};
  return {};
}

Status parse_codestream(Bytes codestream, Jpeg2000Info& info) {
  Siz siz{};
  ILP_TRY(read_siz(codestream, siz));
  ILP_TRY(describe_image(siz, info));
  std::size_t at = 2;
  Segment segment;
  while (true) {  // bound: the codestream; `at` grows
    ILP_TRY(segment_at(codestream, at, segment));
    if (segment.marker == marker_sot) break;
    if (segment.marker == marker_cod) {
      if (segment.length < 12) return malformed(at);
      info.layers = static_cast<int>(get16(codestream, at + 6));
      info.wavelet_levels = codestream[at + 9];
    }
    at += 2 + segment.length;
  }
  if (info.layers < 1 || info.wavelet_levels > 32) return malformed(at);
  info.codestream = codestream;
  return {};
}

}  // namespace

std::size_t jp2_overhead(std::size_t metadata_bytes) {
  const std::size_t metadata_box = metadata_bytes == 0 ? 0 : box_head + metadata_uuid.size() + metadata_bytes;
  return signature_bytes + file_type_bytes + header_bytes + metadata_box + box_head;
}

void write_jp2_boxes(std::int32_t width, std::int32_t height, int bits, std::span<const std::uint8_t> metadata,
                     std::size_t codestream_bytes, std::span<std::uint8_t> file) {
  Writer w{file};
  w.box(signature_bytes, box_signature);
  w.u32(0x0d0a870a);
  w.box(file_type_bytes, box_file_type);
  w.u32(brand);
  w.u32(0);
  w.u32(brand);
  w.box(header_bytes, box_header);
  w.box(image_header_bytes, box_image_header);
  w.u32(static_cast<std::uint32_t>(height));
  w.u32(static_cast<std::uint32_t>(width));
  w.u16(1);
  w.u8(static_cast<std::uint8_t>(bits - 1));
  w.u8(compression_jpeg2000);
  w.u8(0);
  w.u8(0);
  w.box(colour_bytes, box_colour);
  w.u8(1);
  w.u8(0);
  w.u8(0);
  w.u32(greyscale);
  if (!metadata.empty()) {
    w.box(box_head + metadata_uuid.size() + metadata.size(), box_uuid);
    w.copy(metadata_uuid);
    w.copy(metadata);
  }
  w.box(box_head + codestream_bytes, box_codestream);
}

void write_codestream_box(std::size_t codestream_bytes, std::span<std::uint8_t> box) {
  Writer w{box};
  w.box(box_head + codestream_bytes, box_codestream);
}

Status correct_main_header(std::span<std::uint8_t> codestream, int bits, int shift) {
  Siz siz{};
  ILP_TRY(read_siz(codestream, siz));
  constexpr std::size_t precision_at = 2 + 4 + 36;
  codestream[precision_at] = static_cast<std::uint8_t>(bits - 1);
  std::size_t at = 2;
  Segment segment;
  while (true) {  // bound: the codestream; `at` grows
    ILP_TRY(segment_at(codestream, at, segment));
    if (segment.marker == marker_sot) return malformed(at);
    if (segment.marker == marker_qcd) break;
    at += 2 + segment.length;
  }
  // Reversible: one byte a band, the exponent in its upper five bits.
  for (std::size_t i = at + 5; i < at + 2 + segment.length; ++i) {
    if ((codestream[i] >> 3U) < shift) return malformed(i);
    codestream[i] = static_cast<std::uint8_t>(codestream[i] - (shift << 3U));
  }
  return {};
}

Status read_layer_table(Bytes codestream, LayerTable& table) {
  table = {};
  Jpeg2000Info info;
  ILP_TRY(parse_codestream(codestream, info));
  if (info.layers > limits::max_quality_layers) return malformed(0);
  std::size_t at = 2;
  Segment segment;
  std::size_t lengths_end = 0;
  while (at + 2 <= codestream.size() && get16(codestream, at) != marker_sod) {
    ILP_TRY(segment_at(codestream, at, segment));
    if (segment.marker == marker_cod) table.cod = at;
    if (segment.marker == marker_sot) {
      if (table.sot != 0 || segment.length != 10) return malformed(at);
      table.sot = at;
    }
    if (segment.marker == marker_plt) {
      if (table.plt != 0 || segment.length < 4) return malformed(at);
      table.plt = at;
      lengths_end = at + 2 + segment.length;
    }
    at += 2 + segment.length;
  }
  if (table.cod == 0 || table.sot == 0 || table.plt == 0) return malformed(at);
  table.data = at + 2;
  table.layers = info.layers;
  std::size_t entry = table.plt + 5;
  const std::size_t entries = entry;
  std::size_t data_end = 0;
  for (int layer = 0; layer < info.layers; ++layer) {
    for (int resolution = 0; resolution <= info.wavelet_levels; ++resolution) {
      // Seven bits a byte, most significant first; the upper bit says that more follow.
      std::size_t length = 0;
      bool more = true;
      while (more) {  // bound: the table; `entry` grows
        if (entry >= lengths_end || length > codestream.size()) return malformed(entry);
        length = (length << 7U) | (codestream[entry] & 0x7fU);
        more = (codestream[entry++] & 0x80U) != 0;
      }
      data_end += length;
    }
    const auto i = static_cast<std::size_t>(layer);
    table.data_end[i] = data_end;
    table.lengths_bytes[i] = entry - entries;
  }
  if (entry != lengths_end || table.data + data_end + 2 != codestream.size()) return malformed(entry);
  for (int layer = 0; layer < info.layers; ++layer) {
    const auto i = static_cast<std::size_t>(layer);
    const std::size_t dropped = (entry - entries) - table.lengths_bytes[i];
    table.bytes[i] = table.data - dropped + table.data_end[i] + 2;
  }
  return {};
}

void cut_codestream(std::span<std::uint8_t> codestream, const LayerTable& table, int layers) {
  const auto last = static_cast<std::size_t>(layers - 1);
  const std::size_t entries = table.plt + 5;
  const std::size_t rest = entries + table.lengths_bytes[static_cast<std::size_t>(table.layers - 1)];
  const std::size_t new_rest = entries + table.lengths_bytes[last];
  put16(codestream, table.cod + 6, static_cast<unsigned>(layers));
  put16(codestream, table.plt + 2, static_cast<unsigned>(3 + table.lengths_bytes[last]));
  std::memmove(codestream.data() + new_rest, codestream.data() + rest, table.data - rest + table.data_end[last]);
  put16(codestream, table.bytes[last] - 2, marker_eoc);
  put32(codestream, table.sot + 6, static_cast<std::uint32_t>(table.bytes[last] - 2 - table.sot));
}

Status parse_jp2(Bytes file, Jpeg2000Info& info) {
  info = {};
  if (file.size() >= 2 && get16(file, 0) == marker_soc) return parse_codestream(file, info);
  if (file.size() < signature_bytes || get32(file, 0) != signature_bytes || get32(file, 4) != box_signature) {
    return {StatusCode::unsupported_format, 0};
  }
  std::size_t at = 0;
  while (at + box_head <= file.size()) {
    std::uint64_t length = get32(file, at);
    const std::uint32_t type = get32(file, at + 4);
    std::size_t head = box_head;
    const std::size_t left = file.size() - at;
    if (length == 1) {
      if (left < 16) return {StatusCode::truncated, static_cast<std::int64_t>(at), 0};
      length = (static_cast<std::uint64_t>(get32(file, at + 8)) << 32U) | get32(file, at + 12);
      head = 16;
    } else if (length == 0) {
      length = left;
    }
    if (length < head) return malformed(at);
    // A codestream may be cut short; the decoder judges the rest.
    const bool complete = length <= left;
    const Bytes content = file.subspan(at + head, (complete ? static_cast<std::size_t>(length) : left) - head);
    if (type == box_codestream) return parse_codestream(content, info);
    if (!complete) return {StatusCode::truncated, static_cast<std::int64_t>(at), static_cast<std::int64_t>(length)};
    if (type == box_uuid && content.size() >= metadata_uuid.size() &&
        std::memcmp(content.data(), metadata_uuid.data(), metadata_uuid.size()) == 0) {
      info.metadata = content.subspan(metadata_uuid.size());
    }
    at += static_cast<std::size_t>(length);
  }
  return {StatusCode::truncated, static_cast<std::int64_t>(file.size()), 0};
}

}  // namespace ilp
