// Finds earlier keyframes of the same ground by their appearance, whatever the heading and the height.
//
// An inverted file over binary descriptors: the nearest of 2048 descriptors (the vocabulary) chooses a list, and of its
// entries those with a similar signature vote for their keyframe, separately for each difference of angle and of level
// (H. Jegou, M. Douze, C. Schmid, "Hamming embedding and weak geometric consistency for large scale image search", ECCV
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
  std::uint16_t votes = 0;  ///< for the best difference of angle and level; weighted, only for comparison
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
    std::int32_t distance;  ///< bits of the signatures
  };
  FixedVector<Alike, 8192> alike;  ///< entries that look like one feature
};

/// Its bytes follow from what is in its slots and from nothing else: a restart that inserts the same keyframes into the
/// same slots gives the same bytes, and a query the same answer.
///
/// The vocabulary comes from the keyframes in the first limits::place_vocabulary_places slots. They are inserted before
/// all others and never removed. Until they are complete, a query compares with all of them.
///
/// Memory may be damaged by radiation. Every call asserts first that the lists lie within the entries (assertion_failed
/// if not; whoever owns the index fills it again), and passes over entries of no place.
class PlaceIndex {
 public:
  void clear();

  /// Of the features, limits::indexed_place_features at most are kept, evenly chosen. A slot of the vocabulary may be
  /// filled with no features, which stands for a keyframe whose features were lost. `invalid_argument` (no such
  /// slot, or it is taken), `not_ready` (the first slots are not complete).
  Status insert(std::size_t slot, std::int64_t keyframe_id, std::span<const PlaceFeature> features);
  /// `invalid_argument` (no such slot, or one of the vocabulary), `not_found` (the slot is free).
  Status remove(std::size_t slot);

  /// At most limits::max_place_candidates keyframes with ids below `excluding_from_id`, the one with most votes first.
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
  static constexpr std::size_t words_per_feature = 5;  ///< whose lists are searched
  using NearestWords = std::array<std::uint16_t, words_per_feature>;
  struct NearWord {
    std::uint16_t distance, word;
  };

  [[nodiscard]] bool lists_are_valid() const;
  [[nodiscard]] std::uint16_t nearest_word(const Descriptor& descriptor) const;
  [[nodiscard]] NearestWords nearest_words(const PlaceFeature& feature) const;
  // The steps of a query for one feature: the entries that look like it, and what they say; then the best places.
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

  // Until the vocabulary is complete: what is indexed of the first places, and its nearest word so far.
  std::array<Descriptor, first_entries> first_descriptors_{};
  std::array<NearWord, first_entries> first_words_{};
  std::array<std::uint16_t, limits::place_vocabulary_places> first_counts_{};

  std::array<std::int64_t, limits::max_places> keyframes_{};
  std::array<std::uint8_t, limits::max_places> taken_{};
  std::uint32_t entry_count_ = 0, places_ = 0, first_places_ = 0;
};
static_assert(sizeof(PlaceIndex) + sizeof(PlaceQueryWorkspace) <= (std::size_t{13} << 19U), "6.5 MiB");

}  // namespace ilp
