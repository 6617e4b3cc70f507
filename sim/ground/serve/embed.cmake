# FILES, separated by commas, become the table of OUT.
string(REPLACE "," ";" FILES "${FILES}")
set(code "#include \"sim/ground/serve/page_files.hpp\"\n\nnamespace ilp::serve {\nnamespace {\nconstexpr PageFile files[] = {\n")
foreach(file ${FILES})
  file(READ ${file} text)
  get_filename_component(name ${file} NAME)
  string(APPEND code "  {\"${name}\", R\"ilp_page(${text})ilp_page\"},\n")
endforeach()
file(WRITE ${OUT} "${code}};\n}  // namespace\nstd::span<const PageFile> page_files() {\n  return files;\n}\n}  // namespace ilp::serve\n")
