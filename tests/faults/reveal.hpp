// Private members for trials, so that flight code need not know of them: in an explicit instantiation access is not
// checked. ILP_REVEAL(Owner, member) in namespace ilp::faults, then object.*revealed(Owner_member{}).
#pragma once

namespace ilp::faults {

template <typename Tag, auto Member>
struct Reveal {
  friend constexpr auto revealed(Tag) { return Member; }
};

}  // namespace ilp::faults

#define ILP_REVEAL(Owner, member)                     \
  struct Owner##_##member {                           \
    friend constexpr auto revealed(Owner##_##member); \
  };                                                  \
  template struct Reveal<Owner##_##member, &Owner::member>
