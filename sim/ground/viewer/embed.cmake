# SCRIPT, STYLE and LICENCE become the string literals of OUT.
set(code "#include \"sim/ground/viewer/resource.hpp\"\n\nnamespace ilp::viewer {\n")
foreach(part SCRIPT STYLE LICENCE)
  file(READ ${${part}} text)
  # Inside a page neither may end its element.
  string(REPLACE "</script" "<\\/script" text "${text}")
  string(TOLOWER ${part} name)
  string(APPEND code "std::string_view ${name}() {\n  return R\"ilp_viewer(${text})ilp_viewer\";\n}\n")
endforeach()
file(WRITE ${OUT} "${code}}  // namespace ilp::viewer\n")
