// The fields of a plain struct at compile time: names, types and order. A structured binding of the struct must be
// possible: it has no base class, and all its members are public.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "fsw/base/fixed_vector.hpp"

#define ILP_FIELDS_1 f1
#define ILP_FIELDS_2 ILP_FIELDS_1, f2
#define ILP_FIELDS_3 ILP_FIELDS_2, f3
#define ILP_FIELDS_4 ILP_FIELDS_3, f4
#define ILP_FIELDS_5 ILP_FIELDS_4, f5
#define ILP_FIELDS_6 ILP_FIELDS_5, f6
#define ILP_FIELDS_7 ILP_FIELDS_6, f7
#define ILP_FIELDS_8 ILP_FIELDS_7, f8
#define ILP_FIELDS_9 ILP_FIELDS_8, f9
#define ILP_FIELDS_10 ILP_FIELDS_9, f10
#define ILP_FIELDS_11 ILP_FIELDS_10, f11
#define ILP_FIELDS_12 ILP_FIELDS_11, f12
#define ILP_FIELDS_13 ILP_FIELDS_12, f13
#define ILP_FIELDS_14 ILP_FIELDS_13, f14
#define ILP_FIELDS_15 ILP_FIELDS_14, f15
#define ILP_FIELDS_16 ILP_FIELDS_15, f16
#define ILP_FIELDS_17 ILP_FIELDS_16, f17
#define ILP_FIELDS_18 ILP_FIELDS_17, f18
#define ILP_FIELDS_19 ILP_FIELDS_18, f19
#define ILP_FIELDS_20 ILP_FIELDS_19, f20
#define ILP_FIELDS_21 ILP_FIELDS_20, f21
#define ILP_FIELDS_22 ILP_FIELDS_21, f22
#define ILP_FIELDS_23 ILP_FIELDS_22, f23
#define ILP_FIELDS_24 ILP_FIELDS_23, f24
#define ILP_FIELDS_25 ILP_FIELDS_24, f25
#define ILP_FIELDS_26 ILP_FIELDS_25, f26
#define ILP_FIELDS_27 ILP_FIELDS_26, f27
#define ILP_FIELDS_28 ILP_FIELDS_27, f28
#define ILP_FIELDS_29 ILP_FIELDS_28, f29
#define ILP_FIELDS_30 ILP_FIELDS_29, f30
#define ILP_FIELDS_31 ILP_FIELDS_30, f31
#define ILP_FIELDS_32 ILP_FIELDS_31, f32
// NOLINTBEGIN(bugprone-macro-parentheses): it makes names.
#define ILP_BIND(number)                   \
  if constexpr (count == number) {         \
    const auto& [ILP_FIELDS_##number] = t; \
    return std::tie(ILP_FIELDS_##number);  \
  }
// NOLINTEND(bugprone-macro-parentheses)

namespace ilp {
namespace fields_detail {

/// Converts to the type of any field.
struct Any {
  template <typename T>
  constexpr operator T() const;  // NOLINT(google-explicit-constructor)
};
template <std::size_t>
using AnyOf = Any;

template <typename T, std::size_t... before, std::size_t... after>
constexpr bool takes(std::index_sequence<before...>, std::index_sequence<after...>) {
  return requires {
    T{AnyOf<before>{}..., {}, AnyOf<after>{}...};
  };
}
template <typename T, std::size_t... all>
constexpr bool takes(std::index_sequence<all...>) {
  return requires {
    T{AnyOf<all>{}...};
  };
}

/// The number of initializers of T without inner braces: an array has one for each element.
template <typename T, std::size_t count = 0>
constexpr std::size_t initializers() {
  if constexpr (takes<T>(std::make_index_sequence<count + 1>{})) {
    return initializers<T, count + 1>();
  } else if constexpr (count == 0 && takes<T>(std::make_index_sequence<2>{})) {
    return initializers<T, 2>();
  } else {
    return count;
  }
}

/// The number of initializers of the field that begins with initializer `at` of `all`.
template <typename T, std::size_t all, std::size_t at, std::size_t elements = 1>
constexpr std::size_t elements_of() {
  if constexpr (at + elements >= all ||
                takes<T>(std::make_index_sequence<at>{}, std::make_index_sequence<all - at - elements>{})) {
    return elements;
  } else {
    return elements_of<T, all, at, elements + 1>();
  }
}
template <typename T, std::size_t all, std::size_t at = 0, std::size_t fields = 0>
constexpr std::size_t count_from() {
  if constexpr (at >= all) {
    return fields;
  } else {
    return count_from<T, all, at + elements_of<T, all, at>(), fields + 1>();
  }
}

#ifdef __clang__
#pragma clang diagnostic ignored "-Wundefined-var-template"
#endif
/// Never defined: only the addresses of its fields are used, at compile time.
template <typename T>
extern const T example;
template <typename T>
struct Address {
  const T* field;
};
template <typename T>
Address(const T*) -> Address<T>;

template <std::size_t count, typename T>
constexpr auto bind(const T& t) {
  ILP_BIND(1)
  ILP_BIND(2)
  ILP_BIND(3)
  ILP_BIND(4)
  ILP_BIND(5)
  ILP_BIND(6)
  ILP_BIND(7)
  ILP_BIND(8)
  ILP_BIND(9)
  ILP_BIND(10)
  ILP_BIND(11)
  ILP_BIND(12)
  ILP_BIND(13)
  ILP_BIND(14)
  ILP_BIND(15)
  ILP_BIND(16)
  ILP_BIND(17)
  ILP_BIND(18)
  ILP_BIND(19)
  ILP_BIND(20)
  ILP_BIND(21)
  ILP_BIND(22)
  ILP_BIND(23)
  ILP_BIND(24)
  ILP_BIND(25)
  ILP_BIND(26)
  ILP_BIND(27)
  ILP_BIND(28)
  ILP_BIND(29)
  ILP_BIND(30)
  ILP_BIND(31)
  ILP_BIND(32)
}

/// The name of the field at an address: the last word of the compiler's text for the address.
template <Address address>
constexpr auto name_at() {
  const std::string_view text = __PRETTY_FUNCTION__;
  constexpr std::string_view letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789";
  const std::size_t last = text.find_last_of(letters);
  const std::size_t before = text.find_last_not_of(letters, last);
  return text.substr(before + 1, last - before);
}

/// A number for the kind of a type. `char` has a kind of its own, because it is signed on some processors only.
template <typename T>
constexpr std::uint64_t kind() {
  if (std::is_floating_point_v<T>) return 1;
  if (std::is_enum_v<T>) return 2;
  if (std::is_same_v<T, bool>) return 3;
  if (std::is_same_v<T, char>) return 7;
  if (std::is_integral_v<T>) return std::is_signed_v<T> ? 4 : 5;
  return 6;
}

constexpr std::uint64_t mixed(std::uint64_t digest, std::uint64_t value) {
  return (digest ^ value) * 0x100000001B3U;  // FNV-1a
}

}  // namespace fields_detail

/// Calls `each` with type and name of every field, in order. At most 32 fields.
template <typename T, typename Each>
constexpr void for_each_field(Each each) {
  using namespace fields_detail;
  constexpr std::size_t count = count_from<T, initializers<T>()>();
  static_assert(count > 0 && count <= 32, "too many fields, or the class around the struct is not complete yet");
  [&]<std::size_t... at>(std::index_sequence<at...>) {
    (each.template operator()<std::remove_cvref_t<decltype(std::get<at>(bind<count>(example<T>)))>>(
         name_at<Address{&std::get<at>(bind<count>(example<T>))}>()),
     ...);
  }
  (std::make_index_sequence<count>{});
}

/// Types whose fields for_each_field can visit.
template <typename T>
concept PlainStruct = std::is_class_v<T> && std::is_aggregate_v<T>;

/// The type (`element`) and the number (`capacity`) of the elements of an array type.
template <typename T>
struct ElementsOf;
template <typename T, std::size_t count>
struct ElementsOf<T[count]> {
  using element = T;
  static constexpr std::size_t capacity = count;
};
template <typename T, std::size_t count>
struct ElementsOf<std::array<T, count>> : ElementsOf<T[count]> {};
template <typename T, std::size_t count>
struct ElementsOf<FixedVector<T, count>> : ElementsOf<T[count]> {};
template <typename T>
concept HasElements = requires {
  typename ElementsOf<T>::element;
};

/// A digest of names, types and order of all fields, at any depth. It is the same for every compiler and processor. A
/// class with private members contributes its size; a number contributes its kind and size.
template <typename T>
constexpr std::uint64_t layout_digest() {
  using fields_detail::mixed;
  std::uint64_t digest = mixed(0xCBF29CE484222325U, sizeof(T));
  if constexpr (HasElements<T>) {
    digest = mixed(mixed(digest, ElementsOf<T>::capacity), layout_digest<typename ElementsOf<T>::element>());
  } else if constexpr (PlainStruct<T>) {
    for_each_field<T>([&]<typename Field>(std::string_view name) {
      for (const char c : name) digest = mixed(digest, static_cast<unsigned char>(c));
      digest = mixed(digest, layout_digest<Field>());
    });
  } else {
    digest = mixed(digest, fields_detail::kind<T>());
  }
  return digest;
}

namespace fields_detail {
template <typename T>
void clear_between(T& object, std::size_t begin, std::size_t end) {
  std::memset(reinterpret_cast<std::byte*>(&object) + begin, 0, end - begin);
}
}  // namespace fields_detail

/// Zeroes the octets that belong to no field, at any depth. A class with private members is not changed. (GCC 12 has
/// __builtin_clear_padding, but it also clears octets after an array of structs with arrays.)
template <typename T>
void clear_padding(T& object) {
  using namespace fields_detail;
  if constexpr (HasElements<T>) {
    constexpr std::size_t capacity = ElementsOf<T>::capacity;
    for (std::size_t i = 0; i < capacity; ++i) clear_padding(std::data(object)[i]);
    if constexpr (requires { object.push_back(object[0]); }) {
      constexpr std::size_t elements = capacity * sizeof(object[0]), size_at = (elements + 3) / 4 * 4;
      clear_between(object, elements, size_at);
      clear_between(object, size_at + sizeof(std::uint32_t), sizeof(T));
    }
  } else if constexpr (PlainStruct<T>) {
    std::size_t end = 0;
    const auto clear_next = [&]<typename Field>(const Field& field) {
      const auto at = static_cast<std::size_t>(reinterpret_cast<const std::byte*>(&field) -
                                               reinterpret_cast<const std::byte*>(&object));
      clear_between(object, end, at);
      clear_padding(const_cast<Field&>(field));
      end = at + sizeof(field);
    };
    std::apply([&](const auto&... fields) { (clear_next(fields), ...); },
               bind<count_from<T, initializers<T>()>()>(object));
    clear_between(object, end, sizeof(T));
  } else {
    static_assert(!std::is_class_v<T> || std::has_unique_object_representations_v<T>, "padding that nobody clears");
  }
}

/// Whether a field, at any depth, is a pointer.
template <typename T>
constexpr bool has_pointers() {
  if constexpr (HasElements<T>) {
    return has_pointers<typename ElementsOf<T>::element>();
  } else if constexpr (PlainStruct<T>) {
    bool any = false;
    for_each_field<T>([&]<typename Field>(std::string_view) { any = any || has_pointers<Field>(); });
    return any;
  } else {
    return std::is_pointer_v<T> || std::is_member_pointer_v<T>;
  }
}

}  // namespace ilp
