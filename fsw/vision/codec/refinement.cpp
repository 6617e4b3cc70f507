#include "fsw/vision/codec/refinement.hpp"

#include <cstring>

#include "cfg/limits.hpp"
#include "fsw/base/argument.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/base/little_endian.hpp"
#include "fsw/vision/codec/jp2_file.hpp"

namespace ilp {
namespace {

constexpr std::uint8_t magic[] = {'I', 'L', 'P', 'D'};

template <typename Unsigned>
std::uint8_t* put(std::uint8_t* at, Unsigned value) {
  store_little_endian(value, at);
  return at + sizeof(value);
}
template <typename Unsigned>
Unsigned take(const std::uint8_t*& at) {
  const std::uint8_t* from = at;
  at += sizeof(Unsigned);
  return load_little_endian<Unsigned>(from);
}

// Head and data of the shorter file do not overlap, so that the longer one has at most the bytes of the two files.
bool consistent(const RefinementHeader& h, std::size_t own) {
  const std::uint64_t head = h.head_end, same = h.same_data;
  return h.first_layer >= 2 && h.last_layer >= h.first_layer && h.last_layer <= limits::max_quality_layers &&
         h.same_head <= h.head_end && h.same_head <= h.shorter_data &&
         std::uint64_t{h.shorter_data} + same <= h.shorter_bytes && head + same <= h.bytes &&
         own == h.bytes - h.same_head - same;
}

}  // namespace

Status compare_layers(std::span<const std::uint8_t> file, int layers, LayerSegments& segments) {
  segments = {};
  Jpeg2000Info info;
  ILP_TRY(parse_jp2(file, info));
  if (layers < 1 || layers >= info.layers) return out_of_range(Argument::layers, layers);
  LayerTable table;
  ILP_TRY(read_layer_table(info.codestream, table));
  const auto offset = static_cast<std::size_t>(info.codestream.data() - file.data());
  const auto last = static_cast<std::size_t>(layers - 1);
  // The head differs in the lengths of box and tile part, the number of layers and the list of packets.
  constexpr std::size_t box_head = 8;
  const std::size_t fewer_lengths =
      table.lengths_bytes[static_cast<std::size_t>(table.layers - 1)] - table.lengths_bytes[last];
  segments.shorter_bytes = offset + table.bytes[last];
  segments.same_head = offset >= box_head ? offset - box_head : 0;
  segments.head_end = offset + table.data;
  segments.shorter_data = segments.head_end - fewer_lengths;
  segments.same_data = table.data_end[last];
  return {};
}

void write_refinement_header(const RefinementHeader& header, std::span<std::uint8_t, refinement_header_bytes> out) {
  std::memcpy(out.data(), magic, sizeof(magic));
  std::uint8_t* at = put(out.data() + sizeof(magic), static_cast<std::uint64_t>(header.product_id));
  at = put(at, header.first_layer);
  at = put(at, header.last_layer);
  for (const std::uint32_t value : {header.shorter_bytes, header.bytes, header.crc32, header.same_head, header.head_end,
                                    header.shorter_data, header.same_data}) {
    at = put(at, value);
  }
}

Status read_refinement(std::span<const std::uint8_t> file, RefinementHeader& header,
                       std::span<const std::uint8_t>& own) {
  header = {};
  if (file.size() < refinement_header_bytes + refinement_tail_bytes) {
    return {StatusCode::truncated, static_cast<std::int64_t>(file.size())};
  }
  if (std::memcmp(file.data(), magic, sizeof(magic)) != 0) return {StatusCode::parse_error, 0};
  const std::size_t end = file.size() - refinement_tail_bytes;
  if (load_little_endian<std::uint32_t>(file.data() + end) != crc32(file.first(end)))
    return {StatusCode::parse_error, static_cast<std::int64_t>(end)};
  const std::uint8_t* at = file.data() + sizeof(magic);
  header.product_id = static_cast<std::int64_t>(take<std::uint64_t>(at));
  header.first_layer = take<std::uint8_t>(at);
  header.last_layer = take<std::uint8_t>(at);
  for (std::uint32_t* value : {&header.shorter_bytes, &header.bytes, &header.crc32, &header.same_head, &header.head_end,
                               &header.shorter_data, &header.same_data}) {
    *value = take<std::uint32_t>(at);
  }
  own = file.subspan(refinement_header_bytes, end - refinement_header_bytes);
  if (!consistent(header, own.size())) return {StatusCode::parse_error, sizeof(magic)};
  return {};
}

Status refine(const RefinementHeader& header, std::span<const std::uint8_t> own, std::span<const std::uint8_t> shorter,
              std::span<std::uint8_t> out) {
  if (shorter.size() != header.shorter_bytes || out.size() != header.bytes || !consistent(header, own.size())) {
    return out_of_range(Argument::samples, shorter.size());
  }
  std::uint8_t* at = out.data();
  const auto append = [&at](std::span<const std::uint8_t> bytes) {
    if (!bytes.empty()) std::memcpy(at, bytes.data(), bytes.size());
    at += bytes.size();
  };
  const std::size_t own_head = header.head_end - header.same_head;
  append(shorter.first(header.same_head));
  append(own.first(own_head));
  append(shorter.subspan(header.shorter_data, header.same_data));
  append(own.subspan(own_head));
  return crc32(out) == header.crc32 ? Status{} : Status{StatusCode::parse_error, header.product_id};
}

}  // namespace ilp
