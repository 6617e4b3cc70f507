// Files that come down: names, records, refinements, products. What is bad gives its fault in words; nothing else is
// thrown.
#include <cmath>
#include <string>

#include "fsw/vision/codec/refinement.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/intake/ids.hpp"
#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/ground/intake/missing.hpp"
#include "sim/host/files.hpp"
#include "tests/fuzz/ground/known_outbox.hpp"

namespace ilp::fuzz {
namespace {

using intake::BadFile;
using Bytes = std::vector<std::uint8_t>;

std::string text_of(Octets octets) {
  return {octets.begin(), octets.end()};
}

std::string choose_name(Choices& choices) {
  static const char* const kinds[] = {"records-", "points-", "events-", "product-", "", "product-000001"};
  static const char* const ends[] = {".ilp", "-image.jp2", "-depth.jp2", ".ilr", "-image-2.ilr", ""};
  const std::uint8_t choice = choices.byte();
  std::string name = kinds[choice % std::size(kinds)];
  name += (choice & 64U) != 0 ? std::to_string(choices.number(8)) : text_of(choices.bytes());
  return name + ends[choices.byte() % std::size(ends)];
}

/// A refinement of a product that is there, with numbers that the input chooses.
Bytes choose_refinement(Choices& choices) {
  RefinementHeader header;
  header.product_id = static_cast<std::int64_t>((choices.byte() & 1U) != 0 ? choices.number(8) : choices.byte());
  header.first_layer = choices.byte();
  header.last_layer = choices.byte();
  for (std::uint32_t* value : {&header.shorter_bytes, &header.bytes, &header.crc32, &header.same_head, &header.head_end,
                               &header.shorter_data, &header.same_data}) {
    *value = (choices.byte() & 1U) != 0 ? choices.u32() : choices.u16();
  }
  const Octets own = choices.bytes();
  Bytes file(refinement_header_bytes);
  write_refinement_header(header, std::span(file).first<refinement_header_bytes>());
  file.insert(file.end(), own.begin(), own.end());
  file.resize(file.size() + refinement_tail_bytes);
  return file;
}

void look_at(intake::Outbox outbox) {
  intake::Flight flight = intake::index_flight(outbox);
  for (const auto& [id, keyframe] : flight.keyframes) {
    require(id >= 0 && id <= intake::largest_id, "an id that no flight has");
    require(keyframe.name == host::safe_name(keyframe.name), "a name that is not safe");
    if (keyframe.posed()) require(std::isfinite(keyframe.pose->centre[0]), "a pose that is none");
  }
  static_cast<void>(intake::missing_of(flight));
}

}  // namespace

void ground_outbox(Octets input) {
  Choices choices(input);
  intake::OutboxBuilder builder;
  for (int i = 0; i < 6 && !choices.empty(); ++i) {
    const std::uint8_t what = choices.byte();
    if (what % 4 == 0) {
      const Octets octets = choices.bytes();
      builder.add(choose_name(choices), Bytes(octets.begin(), octets.end()));
    } else if (what % 4 == 1) {
      KnownFile file{choose_name(choices), choose_refinement(choices)};
      change(choices, file);
      builder.add(file.name, file.bytes);
    } else {
      KnownFile file = known_outbox()[choices.byte() % known_outbox().size()];
      change(choices, file);
      if ((what & 32U) != 0) file.name = choose_name(choices);
      builder.add(file.name, file.bytes);
    }
  }
  look_at(builder.finish());
}

void ground_records(Octets input) {
  Choices choices(input);
  intake::OutboxBuilder builder;
  for (const KnownFile& known : known_outbox()) {
    if (!known.name.ends_with(".ilp")) continue;
    KnownFile file = known;
    change(choices, file);
    try {
      static_cast<void>(intake::parse_record_file(file.bytes));
    } catch (const BadFile& fault) {
      require(std::string(fault.what()).size() > 5, "a fault without words");
    }
    builder.add(file.name, file.bytes);
  }
  look_at(builder.finish());
}

void ground_metadata(Octets input) {
  const intake::Metadata metadata(input);
  for (const char* key : {"keyframe", "time_ns", "width", "grant_bytes", "strip"}) {
    const auto id = metadata.id(key);
    require(!id || intake::is_id(*id), "an id that no flight has");
    static_cast<void>(metadata.integer(key));
    const auto number = metadata.number(key);
    require(!number || std::isfinite(*number), "a number that is none");
    static_cast<void>(metadata.text(key));
  }
  if (const auto camera = intake::camera_of(metadata)) require(camera->fx > 0 && camera->width > 0, "a camera");
  static_cast<void>(intake::pose_record_of(metadata));
  if (const auto scale = intake::depth_scale_of(metadata)) require(scale->step > 0, "a scale");
}

void ground_product(Octets input) {
  Choices choices(input);
  KnownFile file;
  const std::uint8_t which = choices.byte();
  if (which == 0) {
    const Octets rest = choices.rest();
    file.bytes.assign(rest.begin(), rest.end());
  } else {
    file = known_outbox()[which % known_outbox().size()];
    change(choices, file);
  }
  try {
    const intake::Product product = intake::decode_product(file.bytes);
    require(product.samples.samples.size() ==
                static_cast<std::size_t>(product.samples.width) * static_cast<std::size_t>(product.samples.height),
            "samples");
  } catch (const BadFile& fault) {
    require(std::string(fault.what()).size() > 5, "a fault without words");
  }
}

}  // namespace ilp::fuzz
