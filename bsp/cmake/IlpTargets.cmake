# Compiler settings shared by every target, and the two kinds of library: flight and host.
include_guard()

# The option is in a file that the compiler reads, and no part of the command line of a source: `sim/fly` and `tests/run`,
# which share a folder, switch it without compiling again what the other one has compiled.
set(warning_options ${CMAKE_BINARY_DIR}/warning-options)
if(ILP_WERROR)
  file(WRITE ${warning_options} "-Werror\n")
else()
  file(WRITE ${warning_options} "\n")
endif()

# How the project itself is compiled and linked. Programs of others that use its installed libraries have options of
# their own (bsp/library/library.cmake).
add_library(ilp_options INTERFACE)
target_compile_options(ilp_options INTERFACE
  -Wall -Wextra -Wconversion -Wshadow @${warning_options}
  # Where several sources are one translation unit, a name of one is no shadow in another one, and all are included.
  $<$<BOOL:$<TARGET_PROPERTY:UNITY_BUILD>>:-Wno-shadow -Wno-subobject-linkage>
  # False positives on std::string in GCC 12 (bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  # GCC does not count it to -Wconversion.
  $<$<CXX_COMPILER_ID:Clang>:-Wno-sign-conversion>
  # The same bytes on every architecture: no fused multiply-add, no vector-width-dependent sums.
  -ffp-contract=off -fno-math-errno -fno-trapping-math
  # What flies, computes on pixels or is timed is compiled for speed, everything else in less time.
  $<$<CONFIG:Release>:$<IF:$<BOOL:$<TARGET_PROPERTY:ILP_O1>>,-O1,-O3>>
  # Hardening: tests/tidy reads it back from the binaries.
  -fstack-protector-strong -fPIE
  $<$<STREQUAL:${CMAKE_SYSTEM_PROCESSOR},aarch64>:-mbranch-protection=standard>)
# A toolchain, or a target by its property ILP_STATIC, asks for static programs; a -pie after -static-pie would undo it.
target_link_options(ilp_options INTERFACE
  $<IF:$<OR:$<BOOL:${ILP_STATIC}>,$<BOOL:$<TARGET_PROPERTY:ILP_STATIC>>>,-static-pie,-pie>
  -Wl,-z,relro,-z,now,-z,noexecstack)
if(NOT ILP_SANITIZE AND NOT ILP_FUZZ)
  # Needs an optimising compiler. The sanitizers look at the same calls.
  target_compile_options(ilp_options INTERFACE -U_FORTIFY_SOURCE $<$<NOT:$<CONFIG:Debug>>:-D_FORTIFY_SOURCE=2>)
endif()
if(ILP_PACKAGE)
  # As given, and as a compiler cache gives them.
  file(RELATIVE_PATH up ${CMAKE_BINARY_DIR} ${CMAKE_SOURCE_DIR})
  target_compile_options(ilp_options INTERFACE -ffile-prefix-map=${CMAKE_SOURCE_DIR}/= -ffile-prefix-map=${CMAKE_BINARY_DIR}=build
                         -ffile-prefix-map=${up}=)
endif()
if(ILP_FUZZ)
  # Tracing of comparisons takes four fifths of the time; what the targets choose from is good at finding them.
  # What clang warns of and the compilers of the other builds do not must not keep the targets from being tried.
  target_compile_options(ilp_options INTERFACE -fsanitize=fuzzer-no-link -fno-sanitize-coverage=trace-cmp -Wno-error)
endif()
if(ILP_SANITIZE OR ILP_FUZZ)
  # Flight classes have no run-time type information for the vptr check to read.
  target_compile_options(ilp_options INTERFACE -fsanitize=address,undefined -fno-sanitize=vptr -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(ilp_options INTERFACE -fsanitize=address,undefined)
endif()

# What every source is compiled with.
get_filename_component(ILP_PROFILE_FOLDER ${ILP_PROFILE} ABSOLUTE BASE_DIR ${CMAKE_SOURCE_DIR}/cfg/profiles)
if(NOT EXISTS ${ILP_PROFILE_FOLDER}/profile.hpp)
  message(FATAL_ERROR "ILP_PROFILE=${ILP_PROFILE}: there is no ${ILP_PROFILE_FOLDER}/profile.hpp. "
                      "Name flight, host or large, or a folder with a profile.hpp like those of cfg/profiles.")
endif()
add_library(ilp_settings INTERFACE)
target_include_directories(ilp_settings INTERFACE
                           $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}> $<BUILD_INTERFACE:${ILP_PROFILE_FOLDER}>)
target_link_libraries(ilp_settings INTERFACE $<BUILD_INTERFACE:ilp_options>)

# ilp_unity(TARGET NUMBER): with ILP_UNITY, NUMBER sources in one translation unit: what they include is compiled once.
# The presets flight and aarch64 compile each source alone, which shows whether it includes what it needs.
function(ilp_unity name number)
  set_target_properties(${name} PROPERTIES UNITY_BUILD ${ILP_UNITY} UNITY_BUILD_BATCH_SIZE ${number})
endfunction()

# ilp_flight_library(NAME SOURCES... [DEPENDS targets...]): code that flies (architecture, "Memory", "Errors").
function(ilp_flight_library name)
  cmake_parse_arguments(ARG "" "" "DEPENDS" ${ARGN})
  add_library(${name} STATIC ${ARG_UNPARSED_ARGUMENTS})
  target_link_libraries(${name} PUBLIC ilp_settings ${ARG_DEPENDS})
  target_compile_options(${name} PRIVATE -fno-exceptions -fno-rtti -fno-threadsafe-statics -ffunction-sections -fdata-sections)
  ilp_unity(${name} 8)
  set_property(GLOBAL APPEND PROPERTY ILP_FLIGHT_LIBRARIES ${name})
endfunction()

# ilp_eigen(TARGET): Eigen with fixed sizes only; any allocation is a compile-time or run-time assertion.
function(ilp_eigen name)
  target_include_directories(${name} SYSTEM PUBLIC $<TARGET_PROPERTY:Eigen3::Eigen,INTERFACE_INCLUDE_DIRECTORIES>)
  # The layout of fixed-size matrices depends on EIGEN_DONT_VECTORIZE, so whoever includes a header needs it.
  target_compile_definitions(${name} PUBLIC EIGEN_DONT_VECTORIZE
                             $<BUILD_INTERFACE:EIGEN_NO_MALLOC> $<BUILD_INTERFACE:EIGEN_DONT_PARALLELIZE>
                             $<BUILD_INTERFACE:EIGEN_NO_DEBUG>)
endfunction()

# ilp_host_library(NAME SOURCES... [DEPENDS targets...] [FAST]): host code, heap and exceptions allowed. FAST code computes
# on every pixel or cell; the rest is compiled with -O1, in half the time.
function(ilp_host_library name)
  cmake_parse_arguments(ARG "FAST" "" "DEPENDS" ${ARGN})
  add_library(${name} STATIC ${ARG_UNPARSED_ARGUMENTS})
  target_link_libraries(${name} PUBLIC ilp_settings ${ARG_DEPENDS})
  if(NOT ARG_FAST)
    set_target_properties(${name} PROPERTIES ILP_O1 ON)
  endif()
  ilp_unity(${name} 16)
  set_property(GLOBAL APPEND PROPERTY ILP_HOST_LIBRARIES ${name})
endfunction()

# ilp_host_program(NAME SOURCES... [DEPENDS targets...]): a program of host libraries.
function(ilp_host_program name)
  cmake_parse_arguments(ARG "" "" "DEPENDS" ${ARGN})
  add_executable(${name} ${ARG_UNPARSED_ARGUMENTS})
  target_link_libraries(${name} PRIVATE ${ARG_DEPENDS} ilp_build_version)
  set_target_properties(${name} PROPERTIES ILP_O1 ON)
endfunction()
