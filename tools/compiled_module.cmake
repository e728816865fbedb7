# pip compiles in a new folder each time. Therefore an install stores its compiled module in build/compiled, and the next
# install with the same settings and sources takes it from there. The file STORE-SOURCES holds a module, where STORE is a
# path that ends in a hash of the settings, and SOURCES is a hash of the sources.
get_filename_component(hardlimit_root "${CMAKE_CURRENT_LIST_DIR}" DIRECTORY)

function(hash_sources result)
  file(GLOB_RECURSE files "${hardlimit_root}/core/*.hpp" "${hardlimit_root}/bindings/*")
  set(all "")
  foreach(file "${hardlimit_root}/CMakeLists.txt" ${files})
    file(SHA256 "${file}" hash)
    string(APPEND all "${file} ${hash}\n")
  endforeach()
  string(SHA256 hash "${all}")
  set(${result} ${hash} PARENT_SCOPE)
endfunction()

# Copies the stored module to this file. Sets `found` to whether there was one that can be loaded.
function(take_module store sources module found)
  execute_process(COMMAND "${CMAKE_COMMAND}" -E copy "${store}-${sources}" "${module}" RESULT_VARIABLE failed ERROR_QUIET)
  if(failed EQUAL 0)
    execute_process(COMMAND "${Python_EXECUTABLE}" -c "import ctypes, sys; ctypes.CDLL(sys.argv[1])" "${module}"
      RESULT_VARIABLE failed ERROR_QUIET)
  endif()
  string(COMPARE EQUAL "${failed}" 0 loads)
  set(${found} ${loads} PARENT_SCOPE)
endfunction()

# Stores this module, in place of that of other sources, unless the sources have changed since it was compiled. The file
# appears complete or not at all, so that two installs can run at once and one can be killed. If the folder cannot be
# written, nothing is stored.
function(store_module store sources module)
  hash_sources(now)
  if(NOT now STREQUAL sources)
    return()
  endif()
  string(RANDOM LENGTH 16 name)
  get_filename_component(folder "${store}" DIRECTORY)
  execute_process(COMMAND "${CMAKE_COMMAND}" -E make_directory "${folder}" ERROR_QUIET)
  execute_process(COMMAND "${CMAKE_COMMAND}" -E copy "${module}" "${store}-${name}" RESULT_VARIABLE failed ERROR_QUIET)
  if(failed EQUAL 0)
    file(GLOB others "${store}-*")
    list(REMOVE_ITEM others "${store}-${name}")
    execute_process(COMMAND "${CMAKE_COMMAND}" -E rm -f ${others} ERROR_QUIET)
    execute_process(COMMAND "${CMAKE_COMMAND}" -E rename "${store}-${name}" "${store}-${sources}" ERROR_QUIET)
  endif()
endfunction()
