// Finds earlier keyframes of the same ground by their appearance, at any heading and height.
//
// An inverted file over binary descriptors. The nearest of 2048 descriptors (the vocabulary) selects a list. Its
// entries with a similar signature vote for their keyframe, separately for each difference of angle and of level (H.
// Jegou, M. Douze, C. Schmid, "Hamming embedding and weak geometric consistency for large scale image search", ECCV
// 2008). Only a true pair has many votes for one rotation and one scale.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "fsw/vision/place/place_features.hpp"

namespace ilp {

struct PlaceCandidate {
  std::int64_t keyframe_id = 0;
  std::uint16_t slot = 0;
  std::uint16_t votes = 0;  ///< for the best difference of angle and level; weighted, so only comparable
};
using PlaceCandidates = FixedVector<PlaceCandidate, limits::max_place_candidates>;

/// Scratch of PlaceIndex::query; a component owns one.
struct PlaceQueryWorkspace {
  static constexpr std::size_t rotations = 16;
  static constexpr std::size_t level_steps = 2 * place_levels - 3;  ///< the two largest differences are not counted
  using PlaceVotes = std::array<std::array<std::uint16_t, rotations>, level_steps>;
  std::array<PlaceVotes, limits::max_places> votes;
  struct Alike {
    std::uint32_t entry;
    std::int32_t distance;  ///< differing bits of the signatures
  };
  FixedVector<Alike, 8192> alike;  ///< entries similar to the present feature
};

/// Its bytes depend only on the content of its slots: after a restart that inserts the same keyframes into the same
/// slots, the bytes and the results of queries are the same.
///
/// The vocabulary is built from the keyframes in the first limits::place_vocabulary_places slots, which are inserted
/// before all others and never removed. Until these slots are filled, a query compares with every keyframe in them.
///
/// Memory may be damaged by radiation. Every call first asserts that the lists lie within the entries; otherwise it
/// returns `assertion_failed`, and the owner fills the index again. Entries without a valid slot are skipped.
class PlaceIndex {
 public:
  void clear();

  /// Inserts a keyframe. At most limits::indexed_place_features of its features are kept, chosen evenly. A slot of the
  /// vocabulary may be filled without features, for a keyframe whose features were lost. Returns `invalid_argument` if
  /// there is no such slot or it is taken, `not_ready` if the slots of the vocabulary are not filled yet.
  Status insert(std::size_t slot, std::int64_t keyframe_id, std::span<const PlaceFeature> features);
  /// Removes the keyframe of a slot. Returns `invalid_argument` if there is no such slot or it belongs to the
  /// vocabulary, `not_found` if it is free.
  Status remove(std::size_t slot);

  /// Finds at most limits::max_place_candidates keyframes with ids below `excluding_from_id`, sorted by votes, the most
  /// first.
  Status query(std::span<const PlaceFeature> features, std::int64_t excluding_from_id, PlaceQueryWorkspace& workspace,
               PlaceCandidates& best) const;

  [[nodiscard]] std::size_t size() const { return places_; }
  [[nodiscard]] bool holds(std::size_t slot) const { return slot < limits::max_places && taken_[slot] != 0; }
  [[nodiscard]] bool has_vocabulary() const { return first_places_ == limits::place_vocabulary_places; }

 private:
  static constexpr std::size_t max_entries = limits::max_places * limits::indexed_place_features;
  static constexpr std::size_t first_entries = limits::place_vocabulary_places * limits::indexed_place_features;
  static constexpr std::size_t words_of_place = limits::place_vocabulary / limits::place_vocabulary_places;

  struct Descriptor {
    std::uint32_t bits[8];
  };
  struct Entry {
    std::uint32_t signature[2];  ///< the descriptor's first 64 bits
    std::uint16_t slot;
    std::uint8_t angle, level;
  };
  static_assert(sizeof(Entry) == 12);
  struct NewEntry {
    Entry entry;
    std::uint16_t word;
  };
  static constexpr std::size_t words_per_feature = 5;  ///< number of lists that a query searches for each feature
  using NearestWords = std::array<std::uint16_t, words_per_feature>;
  struct NearWord {
    std::uint16_t distance, word;
  };

  [[nodiscard]] bool lists_are_valid() const;
  [[nodiscard]] std::uint16_t nearest_word(const Descriptor& descriptor) const;
  [[nodiscard]] NearestWords nearest_words(const PlaceFeature& feature) const;
  // Steps of a query: collect the entries similar to one feature, count their votes; at the end rank the keyframes.
  void collect(const PlaceFeature& feature, std::int64_t excluding_from_id, PlaceQueryWorkspace& w) const;
  void collect(const PlaceFeature& feature, std::size_t word, std::int64_t excluding_from_id,
               PlaceQueryWorkspace& w) const;
  void vote(const PlaceFeature& feature, PlaceQueryWorkspace& w) const;
  void rank(const PlaceQueryWorkspace& w, PlaceCandidates& best) const;
  void insert_entries(std::span<NewEntry> added);
  void take_words(std::size_t slot, std::size_t kept);
  void sort_first_entries();

  // Entries in order of word, slot and feature. Those of word w begin at word_begin_[w].
  std::array<Entry, max_entries> entries_{};
  std::array<std::uint32_t, limits::place_vocabulary + 1> word_begin_{};
  std::array<Descriptor, limits::place_vocabulary> vocabulary_{};
  std::array<std::uint8_t, limits::place_vocabulary> is_word_{};

  // Until the vocabulary is complete: the indexed descriptors of the first slots, and the nearest word of each so far.
  std::array<Descriptor, first_entries> first_descriptors_{};
  std::array<NearWord, first_entries> first_words_{};
  std::array<std::uint16_t, limits::place_vocabulary_places> first_counts_{};

  std::array<std::int64_t, limits::max_places> keyframes_{};
  std::array<std::uint8_t, limits::max_places> taken_{};
  std::uint32_t entry_count_ = 0, places_ = 0, first_places_ = 0;
};
static_assert(sizeof(PlaceIndex) + sizeof(PlaceQueryWorkspace) <= (std::size_t{13} << 19U), "6.5 MiB");

}  // namespace ilp
