// Dawn: refuses it: a compute shader must include '@workgroup_size' in its attributes
// Umbrage: workgroup size is missing on compute shader entry point
@compute fn cs() {}
