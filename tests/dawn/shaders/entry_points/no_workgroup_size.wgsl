// Dawn: refuses it: a compute shader must include '@workgroup_size' in its attributes
@compute fn cs() {}
